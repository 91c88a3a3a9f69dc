// The program `turgor-view`, which `turgor view` starts: simulates a scene in a window. The library does the
// work (window/window.hpp).
#include <filesystem>

#include "app/commands.hpp"
#include "app/other_programs.hpp"
#include "app/program.hpp"
#include "turgor/io/files/input_file.hpp"
#ifdef TURGOR_HAS_WINDOW
#include "turgor/window/window.hpp"
#endif

namespace turgor {

namespace {

#ifdef TURGOR_HAS_WINDOW
void view(WindowOptions options) {
  options.settings = settings_file();
  options.session.plays = false;
  required(view_scene(options));
}
#else
struct WindowOptions {
  std::filesystem::path scene, out;
  std::vector<std::string> overrides;
  struct {
    int threads = 0;
  } session;
};
void view(const WindowOptions& options) {
  throw Failure{
      2,
      "view: this turgor was built without its window (Debian: apt-get install libglfw3-dev libimgui-dev, "
      "then build again); turgor run " +
          options.scene.string() + " simulates the scene and draws pictures"};
}
#endif

}  // namespace

namespace {

void add_view_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<WindowOptions>();
  CLI::App* command = program.add_subcommand(kView.command, kView.about);
  command->footer(
      "Examples:\n"
      "  turgor view\n"
      "  turgor view scenes/palpation.toml\n"
      "  turgor view scenes/incision.toml --set body.torso.ct=patient.nii.gz\n"
      "Press ? in the window for the mouse and key bindings; docs/window.md is a tour.");
  command->add_option("scene", options->scene,
                      "The scene, a TOML file; without it the window shows a gallery");
  add_set_option(*command, options->overrides);
  command->add_option("-o,--out", options->out, "Folder for pictures and videos (default: out/view)");
  command->callback([options, &global] {
    options->session.threads = global.threads;
    if (!options->scene.empty()) required(io::check_input(options->scene));
    view(*options);
  });
}

}  // namespace

}  // namespace turgor

int main(int argc, char** argv) { return turgor::run_program(argc, argv, turgor::add_view_command); }
