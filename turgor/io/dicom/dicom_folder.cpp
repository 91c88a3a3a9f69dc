// Scans a folder: finds the images and judges all other files. A damaged slice must not be dropped silently,
// and a file unrelated to a series must not prevent reading it.
#include <algorithm>
#include <atomic>
#include <cctype>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <unistd.h>

#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/input_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

struct Listed {
  std::vector<fs::path> files;
  std::vector<DicomFile> rest;  // unreadable folders
};

Result<Listed> list_files(const fs::path& folder, bool recursive) {
  constexpr std::size_t kMost = 200000;
  if (Status input = check_input_folder(folder); !input) return input.error();
  Listed listed;
  std::error_code failed;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto it = fs::recursive_directory_iterator(folder, options, failed);
       !failed && it != fs::recursive_directory_iterator(); it.increment(failed)) {
    std::error_code unknown;
    const fs::path& path = it->path();
    const bool is_folder = it->is_directory(unknown), is_hidden = path.filename().string().starts_with('.');
    if (!recursive || is_hidden) it.disable_recursion_pending();
    if (!is_folder) listed.files.push_back(path);
    if (is_folder && recursive && !is_hidden && access(path.c_str(), R_OK | X_OK) != 0)
      listed.rest.push_back(
          {.file = path, .slice = {}, .problem = "a folder without read permission", .series = {}});
    if (listed.files.size() > kMost)
      return Error{
          fmt::format("{}: holds more than {} files; expected the folder of one CT", folder.string(), kMost)};
  }
  if (failed) return Error{fmt::format("{}: cannot be listed: {}", folder.string(), failed.message())};
  std::sort(listed.files.begin(), listed.files.end());
  return listed;
}

/// Common pattern of the file names of a series: the extension, and the text around numbers.
struct NamePattern {
  std::string ending, shape;
  auto operator<=>(const NamePattern&) const = default;
};

NamePattern pattern_of(const fs::path& file) {
  NamePattern pattern{file.extension().string(), ""};
  for (char& c : pattern.ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  if (std::none_of(pattern.ending.begin(), pattern.ending.end(),
                   [](unsigned char c) { return std::isalpha(c); }))
    pattern.ending.clear();
  for (const char c : file.filename().string())
    if (!std::isdigit(static_cast<unsigned char>(c)))
      pattern.shape += c;
    else if (!pattern.shape.ends_with('#'))
      pattern.shape += '#';
  return pattern;
}

/// Matches file names against those of a series' slices in their folders.
class SeriesNames {
 public:
  explicit SeriesNames(const std::vector<const DicomSlice*>& slices) {
    for (const DicomSlice* s : slices) {
      const NamePattern pattern = pattern_of(s->file);
      const std::string folder = s->file.parent_path().string();
      if (!pattern.ending.empty()) endings_.emplace(folder, pattern.ending);
      shapes_.emplace(folder, pattern.shape);
    }
  }
  bool looks_like(const fs::path& file) const {
    if (file.filename().string().starts_with('.')) return false;
    const NamePattern pattern = pattern_of(file);
    const std::string folder = file.parent_path().string();
    return endings_.contains({folder, pattern.ending}) || shapes_.contains({folder, pattern.shape});
  }

 private:
  std::set<std::pair<std::string, std::string>> endings_, shapes_;
};

SeriesNames names_of(const DicomFolder& folder, const std::string& series, bool of_others) {
  std::vector<const DicomSlice*> slices;
  for (const DicomSlice& s : folder.slices)
    if ((s.series == series) != of_others) slices.push_back(&s);
  return SeriesNames(slices);
}

std::string skipped_note(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 5;
  if (names.empty()) return {};
  std::string text = fmt::format("skipped {} that {} not an image of a CT: ",
                                 names.size() == 1 ? "1 file" : fmt::format("{} files", names.size()),
                                 names.size() == 1 ? "is" : "are");
  for (std::size_t i = 0; i < std::min(names.size(), kNamed); i++) text += (i ? ", " : "") + names[i];
  return text + (names.size() > kNamed ? ", …" : "");
}

}  // namespace

Result<DicomFolder> scan_dicom(const Exec& exec, const fs::path& folder, bool recursive,
                               const Progress& progress, const DicomFile* known) {
  const Result<Listed> listed = list_files(folder, recursive);
  if (!listed) return listed.error();
  std::vector<DicomFile> headers(listed->files.size());
  std::atomic<std::size_t> done{0};
  parallel_for(exec, headers.size(), [&](std::size_t i) {
    const fs::path& file = listed->files[i];
    headers[i] = known && known->file == file ? *known : read_dicom_header(file);
    if (progress) progress(double(++done) / double(headers.size()));
  });
  DicomFolder found{.slices = {}, .rest = listed->rest, .file_count = headers.size()};
  for (DicomFile& header : headers)
    if (!header.frames.empty())
      std::move(header.frames.begin(), header.frames.end(), std::back_inserter(found.slices));
    else if (header.slice)
      found.slices.push_back(std::move(*header.slice));
    else
      found.rest.push_back(std::move(header));
  return found;
}

Status judge_rest(const DicomFolder& folder, const std::string& series, std::vector<std::string>& notes) {
  const SeriesNames own = names_of(folder, series, false), others = names_of(folder, series, true);
  std::vector<std::string> skipped;
  using Kind = DicomFile::Kind;
  for (const DicomFile& f : folder.rest) {
    const bool looks_own = own.looks_like(f.file), looks_other = others.looks_like(f.file);
    if (f.kind == Kind::kOtherObject || (f.kind == Kind::kNoDicom && !looks_own && !looks_other))
      skipped.push_back(f.file.filename().string());
    else if (f.series ? *f.series == series : looks_own && !looks_other)
      return Error{fmt::format(
          "{}: {}; expected a slice of the series, as {}: repair it or move it out of the folder",
          f.file.string(), f.problem, f.series ? "its identifier indicates" : "its name indicates")};
    else
      notes.push_back(fmt::format("{}: {}; ignored: {}", f.file.string(), f.problem,
                                  f.series ? "it is of another series" : "its series is unknown"));
  }
  if (!skipped.empty()) notes.push_back(skipped_note(skipped));
  return Done{};
}

}  // namespace turgor::io
