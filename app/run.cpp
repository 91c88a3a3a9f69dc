// `turgor run`: simulates a scene, or draws a recording again, into a folder that appears when it is
// complete. The work is the library's (pictures/run_scene.hpp); here are its options, bars and table.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/pictures/run_scene.hpp"
#include "turgor/sim/report/require.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct CommandOptions {
  fs::path scene, out, replay;
  std::vector<std::string> overrides, required;
  bool quiet = false, force = false, real_time = false;
  LiveOptions live;
};

/// The value, or the end of the command.
template <class T>
T required(Result<T> result) {
  if (!result) throw Failure{2, result.error().message};
  return std::move(*result);
}

/// Work that takes long is announced by a sentence and gets a bar of its own, unless the run is quiet.
RunCallbacks make_callbacks(bool quiet, std::optional<ProgressBar>& bar) {
  RunCallbacks callbacks;
  callbacks.note = [](const std::string& sentence) { note(sentence); };
  if (quiet) return callbacks;
  callbacks.begin = [&bar](const std::string& label, const std::string& sentence) {
    bar.reset();
    if (!sentence.empty()) fmt::print("{}\n", sentence);
    bar.emplace(label);
    return bar->callback();
  };
  return callbacks;
}

void print_row(const std::string& what, const std::string& value) { fmt::print("  {:<34}{}\n", what, value); }

void print_touch(const Json& report) {
  const auto value = [](const Json& table, const char* key) { return table.at(key).get<double>(); };
  for (const Json& body : bodies_of(report, BodyKind::kSfem)) {
    const Json &mesh = body.at("mesh"), &green = body.at("green"), &patch = body.at("patch");
    fmt::print("{}: {} nodes, {} elements, {:.0f} ml\n", body.at("name").get<std::string>(),
               mesh.at("vertices").get<long>(), mesh.at("elements").get<long>(), value(mesh, "volume_ml"));
    print_row("Green's functions", fmt::format("{:.0f} MB, {} in {:.2f} s", value(green, "store_bytes") / 1e6,
                                               green.at("on_demand").get<bool>()    ? "on demand, factor"
                                               : green.at("from_cache").get<bool>() ? "from the cache"
                                                                                    : "computed",
                                               value(green, "seconds")));
    print_row("patches, built beside the ticks",
              fmt::format("{} of at most {} local nodes (median {:.2f} ms, longest {:.2f} ms)",
                          patch.at("rebuilds").get<long>(), patch.at("local_nodes_most").get<long>(),
                          value(patch, "rebuild_p50_ms"), value(patch, "rebuild_max_ms")));
    print_row("largest jump at a hand-over", fmt::format("{:.4f} N", value(patch, "force_jump_max_N")));
  }
  for (const Json& tool : report.value("tools", Json::array())) {
    fmt::print("{}\n", tool.at("name").get<std::string>());
    print_row("largest force",
              fmt::format("{:.3f} N at {:.2f} s", value(tool, "force_max_N"), value(tool, "force_max_at_s")));
    print_row("deepest below the surface at rest", fmt::format("{:.1f} mm", value(tool, "depth_max_mm")));
    const bool by_frame = tool.value("force_every_ms", 1.0) > 1;
    const double p50 = value(tool, "tick_p50_us"), p99 = value(tool, "tick_p99_us"),
                 most = value(tool, "tick_max_us");
    if (by_frame)
      print_row("a frame, one force", fmt::format("{:.1f} ms, 99 of 100 {:.1f} ms, longest {:.1f} ms",
                                                  p50 * 1e-3, p99 * 1e-3, most * 1e-3));
    else
      print_row("a tick, one force",
                fmt::format("{:.1f} µs, 99 of 100 {:.1f} µs, longest {:.1f} µs", p50, p99, most));
  }
}

void print_clothes(const Json& report) {
  for (const Json& cloth : bodies_of(report, BodyKind::kCloth)) {
    const auto value = [&cloth](const char* key) { return cloth.at(key).get<double>(); };
    fmt::print("{}: {} vertices, {} springs, {:.0f} bytes a vertex\n", cloth.at("name").get<std::string>(),
               cloth.at("vertices").get<long>(), cloth.at("springs").get<long>(),
               value("memory_bytes_per_vertex"));
    print_row("a step (median, 99 of 100)",
              fmt::format("{:.2f} ms, {:.2f} ms", value("step_p50_ms"), value("step_p99_ms")));
    print_row("pairs too near, triangles crossing",
              fmt::format("{}, {}", cloth.at("pairs_too_near").get<long>(),
                          cloth.at("triangles_crossing").get<long>()));
  }
}

void print_summary(const Json& report, const fs::path& goal) {
  const auto number = [](const Json& value) {
    return value.is_number() ? value.get<double>() : std::nan("");
  };
  for (const Json& body : bodies_of(report, BodyKind::kLattice))
    fmt::print("{}: {} nodes, {} skin triangles, {:.0f} bytes a node\n", body.at("name").get<std::string>(),
               body.at("body_nodes").get<long>(), body.at("skin_triangles").get<long>(),
               number(body.at("memory_bytes_per_node")));
  for (const Json& wound : report.at("wounds")) {
    fmt::print("{}\n", wound.at("name").get<std::string>());
    print_row("gape, largest and mean", fmt::format("{:.1f} mm, {:.1f} mm", number(wound.at("gape_max_mm")),
                                                    number(wound.at("gape_mean_mm"))));
    print_row("opening area",
              fmt::format("{:.0f} mm² over {:.0f} mm of skin", number(wound.at("opening_area_mm2")),
                          number(wound.at("length_mm"))));
    print_row("angle to Langer's lines",
              fmt::format("{:.0f}°, {:.0f} N/m across the cut", number(wound.at("angle_to_lines_deg")),
                          number(wound.at("tension_across_cut_N_per_m"))));
  }
  print_touch(report);
  print_clothes(report);
  const Json& timing = report.at("timing");
  fmt::print("time\n");
  print_row("a frame (median, 99 of 100)",
            fmt::format("{:.1f} ms, {:.1f} ms", number(timing.at("frame_p50_ms")),
                        number(timing.at("frame_p99_ms"))));
  print_row("reading and building", fmt::format("{:.1f} s", number(timing.at("load_s"))));
  const auto seconds = [&](const char* key) { return number(timing.value(key, Json())); };
  print_row("physics, drawing, files", fmt::format("{:.1f} s, {:.1f} s, {:.1f} s", seconds("physics_s"),
                                                   seconds("drawing_s"), seconds("files_s")));
  print_row("in all", fmt::format("{:.1f} s", number(timing.at("total_s"))));
  for (const Json& warning : report.at("warnings")) fmt::print("warning: {}\n", warning.get<std::string>());
  fmt::print("pictures and files   {}\nreport               {}\n", goal.string(),
             (goal / "report.html").string());
}

/// Where the results are.
fs::path goal_of(const CommandOptions& options, const Json& report) {
  const fs::path scene = report.at("scene").at("file").get<std::string>();
  return required(
      resolved_goal(options.out.empty() ? default_folder(scene, !options.replay.empty()) : options.out));
}

void run(const Exec& exec, const CommandOptions& options) {
  RunOptions goal{.out = options.out, .foreign = options.force ? Foreign::kRemove : Foreign::kRefuse};
  if (options.real_time) goal.live = options.live;
  std::vector<Requirement> requirements;
  for (const std::string& text : options.required) requirements.push_back(required(read_requirement(text)));
  std::optional<ProgressBar> bar;
  const RunCallbacks callbacks = make_callbacks(options.quiet, bar);
  const Json report =
      options.replay.empty()
          ? required(run_scene(exec, required(read_scene(options.scene, options.overrides)), goal, callbacks))
          : required(replay_recording(exec, options.replay, options.overrides, goal, callbacks));
  bar.reset();
  if (!options.quiet) print_summary(report, goal_of(options, report));
  if (options.replay.empty() && !report.value("finite", true))
    throw Failure{kNotFinite,
                  fmt::format("{}: {}", options.scene.string(), report.at("stopped").get<std::string>())};
  for (const Requirement& requirement : requirements)
    if (const std::string missed = required(missed_by(report, requirement)); !missed.empty())
      throw Failure{kNotFinite, missed};
}

}  // namespace

void add_run_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<CommandOptions>();
  CLI::App* command =
      program.add_subcommand("run", "Simulate a scene without a window: pictures, measures, a report");
  command->footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor run scenes/incision.toml --set body.torso.ct=patient.nii.gz --set "
      "body.torso.skin.tension=60\n"
      "  turgor run --replay out/incision/recording.h5 --set output.color=stretch --out out/again\n"
      "  turgor run scenes/palpation.toml --real-time --require \"haptics.missed<0.001\"\n"
      "All keys of a scene are listed in docs/scene.md.");
  command->add_option("scene", options->scene, "The scene, a TOML file");
  command->add_option("-o,--out", options->out, "Folder for the results (default: out/SCENE)");
  command
      ->add_option("--set", options->overrides,
                   "key=value: overrides a key of the scene, key= removes it; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("--replay", options->replay, "Draw this recording.h5 again instead of simulating");
  command->add_flag("--real-time", options->real_time,
                    "A haptic loop beside the frames, by the clock: a hand holds a tool of the scene");
  CLI::Option* device = command->add_option(
      "--device", options->live.device,
      "With --real-time: what the hand holds, one of turgor devices; virtual (default) needs no hardware");
  CLI::Option* tool = command->add_option("--tool", options->live.tool,
                                          "With --real-time: the tool in the hand (default: the first)");
  CLI::Option* rate = command->add_option(
      "--rate", options->live.rate, "With --real-time: ticks of the haptic loop a second (default: 1000)");
  rate->check(number_within(100, 10000, "Hz"));
  for (CLI::Option* option : {device, tool, rate}) option->needs(command->get_option("--real-time"));
  command
      ->add_option(
          "--require", options->required,
          "A number of report.json that must hold, as \"haptics.missed<0.001\": else exit code 3; may "
          "be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
  add_force_option(*command, options->force);
  command->add_flag("-q,--quiet", options->quiet, "No progress bar and no table");
  command->callback([options, &global] {
    if (options->scene.empty() == options->replay.empty())
      throw Failure{2, "run: expected either a scene or --replay FILE; see turgor run --help"};
    if (options->real_time && options->scene.empty())
      throw Failure{2, "run: --real-time needs a scene; a recording has no bodies that answer"};
    run(Exec(global.threads), *options);
  });
}

}  // namespace turgor
