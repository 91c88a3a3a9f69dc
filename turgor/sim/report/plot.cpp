#include "turgor/sim/report/plot.hpp"

#include <algorithm>
#include <cmath>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "turgor/io/file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kScript = ".plot.gp";
constexpr const char* kPicture = ".plot.svg";

/// Colours that are told apart by colour-blind eyes (Okabe and Ito), on light and on dark ground.
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

/// Text between the quotes of a gnuplot string.
std::string quotable(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result;
}

std::string script_of(const Plot& plot) {
  std::string text = fmt::format(
      "set terminal svg size 720,360 dynamic noenhanced font 'sans-serif,13'\n"
      "set output '{}'\nset border 3 lc rgb '#888888'\nset tics nomirror textcolor rgb '#888888'\n"
      "set grid lc rgb '#888888' lw 0.3\nset key textcolor rgb '#888888' top {}\n"
      "set title '{}' textcolor rgb '#888888'\nset xlabel '{}' textcolor rgb '#888888'\n"
      "set ylabel '{}' textcolor rgb '#888888'\n",
      kPicture, plot.logarithmic ? "right" : "left", quotable(plot.title), quotable(plot.x_label),
      quotable(plot.y_label));
  text += plot.logarithmic ? "set logscale y\nset format y '%.0e'\n" : "set yrange [*<0:*]\n";
  std::string commands;
  for (std::size_t c = 0; c < plot.curves.size(); c++) {
    const Curve& curve = plot.curves[c];
    text += fmt::format("$curve{} << END\n", c);
    for (const auto& [x, y] : curve.points)
      if (std::isfinite(x) && std::isfinite(y)) text += fmt::format("{} {}\n", x, y);
    text += "END\n";
    commands += fmt::format("{}$curve{} using 1:2 with {} lw 2 lc rgb '{}' title '{}'", c ? ", " : "", c,
                            curve.points.size() > 40 ? "lines" : "linespoints pt 7 ps 0.5",
                            kColors[c % std::size(kColors)], quotable(curve.label));
  }
  return text + "plot " + commands + "\n";
}

/// Runs gnuplot in the folder, silently; false when it is not there or failed.
bool run_gnuplot(const fs::path& folder) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  char program[] = "gnuplot", script[16];
  std::copy_n(kScript, std::char_traits<char>::length(kScript) + 1, script);
  char* arguments[] = {program, script, nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  return failed == 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string plot_svg(const Plot& plot, const fs::path& folder) {
  const bool empty =
      std::all_of(plot.curves.begin(), plot.curves.end(), [](const Curve& c) { return c.points.empty(); });
  if (empty) return "";
  if (!write_file(folder / kScript, script_of(plot))) return "";
  const bool drawn = run_gnuplot(folder);
  const Result<std::string> svg = read_file(folder / kPicture);
  std::error_code ignored;
  fs::remove(folder / kScript, ignored);
  fs::remove(folder / kPicture, ignored);
  if (!drawn || !svg) return "";
  const std::size_t begin = svg->find("<svg");  // without the XML header
  const bool whole = begin != std::string::npos && svg->find("</svg>", begin) != std::string::npos;
  return whole ? svg->substr(begin) : "";
}

}  // namespace turgor
