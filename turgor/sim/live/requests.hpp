// Requests that change a world between two frames.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World;

/// Starts a cut at the present time.
struct CutRequest {
  lattice::Incision blade;
  int body = 0;  // index into World::lattice_bodies
};
struct WindRequest {
  int body = 0;                   // index into World::cloth_bodies
  std::optional<Vec3d> velocity;  // empty: the wind of the scene [m/s]
};
/// Sets a scene key, or without a value removes the override of the key, so that the scene's text counts. The
/// change acts immediately if possible (change_world.hpp), otherwise after the next reset.
struct ChangeRequest {
  std::string key;
  std::optional<std::string> value;
};
/// Takes back the latest cut that was made by a request: its body returns to its state before the cut.
struct UndoCutRequest {};
/// Lays a single stitch in the frame that is computed next, and pulls it. The same stitch in a scene has its
/// `start` at the end of that frame.
struct StitchRequest {
  int body = 0;                      // index into World::lattice_bodies
  std::optional<int> wound;          // index into World::cuts; empty: the nearest one that the stitch crosses
  std::vector<Vec3d> through;        // points in the CT in the order of the thread, patient frame [m]
  std::string thread = "nylon 3-0";  // name of its preset
  std::optional<double> tension;     // at which it is knotted [N]; empty: when the lips meet under it
  double duration = 0.5;             // of the pull [s]
};
/// Pulls a stitch that was made by a request to another tension, or until the lips meet.
struct TightenRequest {
  int suture = 0;                 // index into World::sutures
  std::optional<double> tension;  // as StitchRequest::tension [N]
  double duration = 0.3;          // [s]
  bool continues = false;         // the drag of the last request goes on: one edit with it
};
/// Removes the latest stitch that was made by a request.
struct UndoStitchRequest {};
using WorldRequest = std::variant<CutRequest, WindRequest, ChangeRequest, UndoCutRequest, StitchRequest,
                                  TightenRequest, UndoStitchRequest>;

/// Applies a request. On error the world is unchanged.
Status apply_request(const Exec& exec, const CutRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const WindRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const ChangeRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const UndoCutRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
/// Stitches (stitch_requests.cpp).
Status apply_request(const Exec& exec, const StitchRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const TightenRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const UndoStitchRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);

}  // namespace turgor
