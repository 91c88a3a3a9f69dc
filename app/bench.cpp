// `turgor bench`: benchmarks of this machine and this engine, printed beside the tables of the papers.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/bench_cloth.hpp"
#include "app/bench_haptics.hpp"
#include "app/bench_rhombus.hpp"
#include "app/bench_sfem.hpp"
#include "app/bench_skin_tension.hpp"
#include "app/commands.hpp"
#include "app/other_programs.hpp"
#include "app/print.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

using nlohmann::ordered_json;

ordered_json to_json(const SkinTensionTimes& t) {
  return {{"grouping_without_ms", t.grouping_without},
          {"grouping_with_ms", t.grouping_with},
          {"frame_without_ms", t.frame_without},
          {"frame_with_ms", t.frame_with}};
}

ordered_json to_json(const OrderingTimes& t) {
  return {{"slabs_ms", t.slabs},
          {"colors_ms", t.colors},
          {"gpu_ms", t.gpu > 0 ? ordered_json(t.gpu) : ordered_json()},
          {"gpu_one_by_one_ms", t.gpu_one_by_one > 0 ? ordered_json(t.gpu_one_by_one) : ordered_json()}};
}

ordered_json to_json(const SkinTensionBench& bench) {
  ordered_json rows = ordered_json::array();
  for (const SkinTensionRow& r : bench.rows)
    rows.push_back({{"data", r.name},
                    {"voxels", {r.voxels.x, r.voxels.y, r.voxels.z}},
                    {"nodes", {r.nodes.x, r.nodes.y, r.nodes.z}},
                    {"skin_triangles", r.skin_triangles},
                    {"paper_rtx_3090", to_json(r.paper)},
                    {"one_thread", to_json(r.one_thread)},
                    {"all_threads", to_json(r.all_threads)},
                    {"body_from_ct_s", r.body_seconds},
                    {"bytes_per_node", r.bytes_per_node},
                    {"sweep_fraction_of_copy_bandwidth", r.bandwidth_fraction},
                    {"sweep_fraction_of_arithmetic", r.arithmetic_fraction},
                    {"vbd_sweep_fraction_of_copy_bandwidth", r.vbd_bandwidth_fraction},
                    {"vbd_sweep_fraction_of_arithmetic", r.vbd_arithmetic_fraction},
                    {"vbd_frame_one_thread_ms", r.vbd_frame_one},
                    {"vbd_frame_ms", r.vbd_frame},
                    {"pbd_frame_by_ordering", to_json(r.pbd_frames)},
                    {"vbd_frame_by_ordering", to_json(r.vbd_frames)},
                    {"residual_pbd_n", r.residual_pbd},
                    {"residual_vbd_n", r.residual_vbd},
                    {"resample_half_ms", r.resample_half},
                    {"resample_full_ms", r.resample_full}});
  ordered_json growth = ordered_json::array();
  for (const GrowthRow& g : bench.growth)
    growth.push_back({{"nodes", g.nodes}, {"awake_ms", g.awake_ms}, {"ms", g.ms}, {"rows_asleep", g.asleep}});
  return {
      {"bench", "skin-tension"},
      {"threads", bench.threads},
      {"gpu", bench.gpu},
      {"copy_bandwidth_gb_per_s", bench.copy_bandwidth * 1e-9},
      {"dense_product_gflops", bench.arithmetic_rate * 1e-9},
      {"growth", growth},
      {"bar", {{"tets", bench.bar_tets}, {"one_thread_ms", bench.bar_frame_one}, {"ms", bench.bar_frame}}},
      {"data", rows}};
}

void print(const SkinTensionBench& bench) {
  print_plain(
      "Skin tension, 5 sweeps a frame, medians. Paper: RTX 3090. This machine: 1 and {} threads, copies "
      "{:.1f} GB/s, dense products {:.0f} Gflop/s.\n\n",
      bench.threads, bench.copy_bandwidth * 1e-9, bench.arithmetic_rate * 1e-9);
  print_plain("{:<11}{:>13}{:>9} | {:>23} | {:>23} | {:>23}\n", "frame [ms]", "nodes", "skin",
              "paper without -> with", "1 thread", fmt::format("{} threads", bench.threads));
  const auto frames = [](const SkinTensionTimes& t) {
    return fmt::format("{:7.2f} -> {:7.2f} {:+4.1f}%", t.frame_without, t.frame_with,
                       100 * (t.frame_with / t.frame_without - 1));
  };
  for (const SkinTensionRow& r : bench.rows)
    print_plain("{:<11}{:>13}{:>9} | {:>23} | {:>23} | {:>23}\n", r.name,
                fmt::format("{}x{}x{}", r.nodes.x, r.nodes.y, r.nodes.z), r.skin_triangles, frames(r.paper),
                frames(r.one_thread), frames(r.all_threads));
  print_plain("\n{:<11}{:>20}{:>20}{:>12}{:>14}{:>10}\n", "", "grouping paper[ms]", "grouping turgor[ms]",
              "vs paper", "CT->body[s]", "B/node");
  for (const SkinTensionRow& r : bench.rows)
    print_plain("{:<11}{:>20}{:>20}{:>12}{:>14.2f}{:>10.1f}\n", r.name,
                fmt::format("{:.0f} -> {:.0f}", r.paper.grouping_without, r.paper.grouping_with),
                fmt::format("{:.0f} -> {:.0f}", r.all_threads.grouping_without, r.all_threads.grouping_with),
                fmt::format("{:.1f} %", 100 * r.all_threads.grouping_with / r.paper.grouping_with),
                r.body_seconds, r.bytes_per_node);
  print_plain("\n{:<11}{:>40}{:>40}\n", "sweep", "pbd: vs copy, vs dense product",
              "vbd: vs copy, vs dense product");
  for (const SkinTensionRow& r : bench.rows)
    print_plain("{:<11}{:>40}{:>40}\n", r.name,
                fmt::format("{:.2f}, {:.2f}", r.bandwidth_fraction, r.arithmetic_fraction),
                fmt::format("{:.2f}, {:.2f}", r.vbd_bandwidth_fraction, r.vbd_arithmetic_fraction));
  print_plain("\nGPU: {}\n{:<11}{:>40}{:>40}\n", bench.gpu, "frame [ms]",
              "pbd: slabs, colors, GPU (no graph)", "vbd: slabs, colors, GPU (no graph)");
  const auto by_ordering = [](const OrderingTimes& t) {
    return fmt::format("{:.1f}, {:.1f}, {}", t.slabs, t.colors,
                       t.gpu > 0 ? fmt::format("{:.2f} ({:.2f})", t.gpu, t.gpu_one_by_one) : "-");
  };
  for (const SkinTensionRow& r : bench.rows)
    print_plain("{:<11}{:>40}{:>40}\n", r.name, by_ordering(r.pbd_frames), by_ordering(r.vbd_frames));
  print_plain("\n{:<11}{:>24}{:>26}{:>26}{:>28}\n", "", "vbd frame 1T/all[ms]", "residual pbd/vbd[N]",
              "resample half/full[ms]", "growth: ns a node, pbd/vbd");
  for (const SkinTensionRow& r : bench.rows) {
    const double nodes = double(r.nodes.x) * r.nodes.y * r.nodes.z;
    print_plain(
        "{:<11}{:>24}{:>26}{:>26}{:>28}\n", r.name,
        fmt::format("{:.1f} / {:.1f}", r.vbd_frame_one, r.vbd_frame),
        fmt::format("{:.2e} / {:.2e}", r.residual_pbd, r.residual_vbd),
        fmt::format("{:.0f} / {:.0f}", r.resample_half, r.resample_full),
        fmt::format("{:.1f} / {:.1f}", 1e6 * r.all_threads.frame_with / nodes, 1e6 * r.vbd_frame / nodes));
  }
  print_plain(
      "\nA bar of {} tetrahedra, springs and volumes, 5 sweeps: {:.2f} ms on 1 thread, {:.2f} ms on {}.\n",
      bench.bar_tets, bench.bar_frame_one, bench.bar_frame, bench.threads);
  print_plain("\nGrowth: frames in the second after the same cut, vbd.\n{:>10}{:>16}{:>16}{:>14}\n", "nodes",
              "no sleep[ms]", "with sleep[ms]", "rows asleep");
  for (const GrowthRow& g : bench.growth)
    print_plain("{:>10}{:>16.2f}{:>16.2f}{:>14.2f}\n", g.nodes, g.awake_ms, g.ms, g.asleep);
}

void check_file(const std::string& path) {
  if (path.empty()) return;
  required(check_file_goal(path));
}

void write_text(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  required(write_file(path, text));
}

void add_cloth_bench(CLI::App& bench, Global& global) {
  CLI::App* cloth =
      bench.add_subcommand("cloth", "Time frames of cloth in the wind, with and without self-collision");
  struct Options {
    int largest = 100000;
    std::string json;
  };
  auto options = std::make_shared<Options>();
  cloth->add_option("--largest", options->largest, "Vertices of the largest sheet")
      ->check(CLI::Range(2500, 1000000));
  cloth->add_option("--json", options->json, "Also write the figures to this file");
  cloth->footer("Example:\n  turgor bench cloth --largest 1000000 --json cloth.json");
  cloth->callback([options, &global] {
    check_file(options->json);
    ClothBench result;
    {
      ProgressBar bar("measuring");
      result = bench_cloth(Exec(global.threads), options->largest, bar.callback());
    }
    print(result);
    write_text(options->json, to_json_text(result));
  });
}

void add_sfem_bench(CLI::App& bench, Global& global) {
  CLI::App* sfem =
      bench.add_subcommand("sfem", "Time Green's functions, haptic ticks, patches and surfaces of bodies");
  struct Options {
    int largest = 10000;
    std::string json;
  };
  auto options = std::make_shared<Options>();
  sfem->add_option("--largest", options->largest, "Nodes of the largest body")
      ->check(CLI::Range(1000, 10000));
  sfem->add_option("--json", options->json, "Also write the figures to this file");
  sfem->footer("Example:\n  turgor bench sfem --largest 3000\n10000 nodes need 4 GB of memory.");
  sfem->callback([options, &global] {
    check_file(options->json);
    SfemBench result;
    {
      ProgressBar bar("measuring");
      result = bench_sfem(Exec(global.threads), options->largest, bar.callback());
    }
    print(result);
    write_text(options->json, to_json_text(result));
  });
}

void add_rhombus_bench(CLI::App& bench) {
  CLI::App* rhombus = bench.add_subcommand("rhombus", "Time forces and pictures of a body of rhombus chains");
  auto json = std::make_shared<std::string>();
  rhombus->add_option("--json", *json, "Also write the figures to this file");
  rhombus->footer("Example:\n  turgor bench rhombus");
  rhombus->callback([json] {
    check_file(*json);
    std::vector<RhombusRow> rows;
    {
      ProgressBar bar("measuring");
      rows = bench_rhombus(bar.callback());
    }
    print(rows);
    write_text(*json, to_json_text(rows));
  });
}

void soak(double minutes, const std::string& json) {
  const HapticSoak done = [minutes] {
    ProgressBar bar("soaking");
    return required(soak_haptics(minutes, bar.callback()));
  }();
  print(done);
  write_text(json, to_json_text(done));
}

void add_haptics_bench(CLI::App& bench, Global& global) {
  CLI::App* haptics = bench.add_subcommand(
      "haptics", "Measure the timing of the haptic loop and the stiffest stable wall (Z-width)");
  struct Options {
    double seconds = 1.5, minutes = 0;
    std::string json, picture;
  };
  auto options = std::make_shared<Options>();
  haptics->add_option("--seconds", options->seconds, "Duration of each of the six loops; 0 skips them")
      ->check(number_within(0, 3600, "s"));
  CLI::Option* minutes =
      haptics->add_option("--minutes", options->minutes,
                          "Soak test instead: touch a liver for this long, with an empty loop in parallel");
  minutes->check(number_within(0.01, 1440, "min"));
  haptics->add_option("--json", options->json, "Also write the figures to this file");
  haptics->add_option("--picture", options->picture, "Write the Z-width maps to this file (.svg)");
  haptics->footer(
      "Examples:\n  turgor bench haptics --picture z-width.svg\n  turgor bench haptics --minutes 10");
  haptics->callback([options, &global] {
    check_file(options->json);
    check_file(options->picture);
    if (!options->json.empty() && options->json == options->picture)
      throw Failure{2, options->json + ": --json and --picture name the same file"};
    if (options->minutes > 0) return soak(options->minutes, options->json);
    HapticsBench result;
    {
      ProgressBar bar("measuring");
      result = bench_haptics(Exec(global.threads), options->seconds, bar.callback());
    }
    print(result);
    write_text(options->json, to_json_text(result));
    write_text(options->picture, z_width_svg(result));
  });
}

}  // namespace

void add_bench_command(CLI::App& program, Global& global) {
  CLI::App* bench = program.add_subcommand(kBench.command, kBench.about);
  bench->require_subcommand(1);
  CLI::App* table = bench->add_subcommand("skin-tension", "Measure Table 4 of the skin tension paper");
  struct Options {
    int shrink = 1;
    std::string only, json;
  };
  auto options = std::make_shared<Options>();
  table->add_option("--only", options->only, "Run one data set only: A, B or C")
      ->check(one_of({"A", "B", "C"}));
  table->add_option("--shrink", options->shrink, "Divide the sizes of the paper by this number")
      ->check(CLI::Range(1, 8));
  table->add_option("--json", options->json, "Also write the figures to this file");
  for (CLI::App* app : {bench, table})
    app->footer(
        "Example:\n  turgor bench skin-tension --only A --json a.json\nData C needs 4 GB of memory; all "
        "three take minutes.");
  table->callback([options, &global] {
    check_file(options->json);
    const Exec exec(global.threads);
    ProgressBar bar("measuring");
    const auto only = options->only.empty() ? std::nullopt : std::optional(options->only);
    const SkinTensionBench result = bench_skin_tension(exec, options->shrink, only, bar.callback());
    print(result);
    write_text(options->json, to_json(result).dump(2) + "\n");
  });
  add_sfem_bench(*bench, global);
  add_cloth_bench(*bench, global);
  add_rhombus_bench(*bench);
  add_haptics_bench(*bench, global);
}

}  // namespace turgor
