// Edits of a scene's text that keep its comments and its order. Old names become current ones
// (scene_renamed.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// Value of a key as TOML, such as "[0, 0, -9.81]": from the overrides, else from the text; empty if neither
/// sets it.
std::string scene_value(const Scene& scene, const std::string& key);

/// Scene text with `key=value` inserted: at the existing key, else as a new line of its table. Error: the
/// text is not TOML, or the key cannot be inserted.
Result<std::string> with_values(const std::string& text, const std::filesystem::path& file,
                                const std::vector<std::string>& overrides);

/// A single stitch by hand that is saved with a scene. Its wound is an incision of the scene, or one of the
/// cuts by hand after them.
struct SavedStitch {
  int wound = 0;
  std::vector<Vec3d> through;  // as SutureScene
  std::string thread;
  std::optional<double> tension;  // [N]; empty: until the wound is closed
  double duration = 0.5;          // [s]
};
/// Tables [suture.NAME] for stitches by hand. Their pull starts at the end of the cut.
std::string sutures_text(const Scene& scene, std::span<const lattice::Incision> cuts,
                         std::span<const SavedStitch> stitches);

/// Tables [incision.NAME] for interactive cuts; the `name` of each cut is that of its body.
std::string incisions_text(const Scene& scene, std::span<const lattice::Incision> cuts);

}  // namespace turgor
