// A CT as a DICOM series: one CT Image Storage file a slice, explicit little endian, stored values = HU.
// Unique identifiers follow from the content, so that the same volume gives the same files.
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <gdcmAttribute.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>

#include "turgor/core/hash.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/file.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace {

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";

/// A UID below 2.25 (those made of numbers that are unique by themselves).
std::string make_uid(std::uint64_t content, std::uint64_t index) {
  return fmt::format("2.25.{}{:020}", 1 + content % 999999999ull, detail::mix(content, index + 1));
}

std::uint64_t content_hash(const CtVolume& ct, const std::string& patient) {
  const Vec3d place[] = {ct.grid.spacing, ct.grid.origin, ct.grid.axes.column[0], ct.grid.axes.column[1],
                         ct.grid.axes.column[2]};
  std::uint64_t hash = hash_bytes(patient.data(), patient.size());
  hash = hash_bytes(&ct.grid.size, sizeof ct.grid.size, hash);
  hash = hash_bytes(place, sizeof place, hash);
  return hash_values(std::span<const std::int16_t>(ct.samples), hash);
}

struct Series {
  const CtVolume& ct;
  std::string patient;
  std::uint64_t content;
};

class Tags {
 public:
  explicit Tags(gdcm::DataSet& set) : set_(set) {}

  void text(std::uint16_t group, std::uint16_t element, gdcm::VR::VRType vr, std::string value) {
    if (value.size() % 2) value += vr == gdcm::VR::UI ? '\0' : ' ';
    bytes(group, element, vr, value.data(), value.size());
  }
  void integer(std::uint16_t group, std::uint16_t element, int value) {
    const auto stored = static_cast<std::uint16_t>(value);
    bytes(group, element, gdcm::VR::US, reinterpret_cast<const char*>(&stored), 2);
  }
  void bytes(std::uint16_t group, std::uint16_t element, gdcm::VR::VRType vr, const char* data,
             std::size_t size) {
    gdcm::DataElement item{gdcm::Tag(group, element)};
    item.SetVR(vr);
    item.SetByteValue(data, static_cast<std::uint32_t>(size));
    set_.Replace(item);
  }

 private:
  gdcm::DataSet& set_;
};

/// A decimal string has at most 16 letters.
std::string decimal(double value) {
  for (int digits = 15; digits > 3; digits--)
    if (std::string text = fmt::format("{:.{}g}", value + 0.0, digits); text.size() <= 16) return text;
  return fmt::format("{:.3g}", value);
}

std::string decimals(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : "\\") + decimal(value);
  return text;
}

void describe_series(const Series& series, Tags& tags) {
  using gdcm::VR;
  tags.text(0x0008, 0x0005, VR::CS, "ISO_IR 192");
  tags.text(0x0008, 0x0008, VR::CS, "DERIVED\\SECONDARY\\AXIAL");
  tags.text(0x0008, 0x0016, VR::UI, kCtImageStorage);
  tags.text(0x0008, 0x0020, VR::DA,
            "");  // date, time, accession number and physician must be there, but may be empty
  tags.text(0x0008, 0x0030, VR::TM, "");
  tags.text(0x0008, 0x0050, VR::SH, "");
  tags.text(0x0008, 0x0090, VR::PN, "");
  tags.text(0x0008, 0x0060, VR::CS, "CT");
  tags.text(0x0008, 0x0070, VR::LO, "Turgor");
  tags.text(0x0008, 0x103e, VR::LO, "Turgor volume");
  tags.text(0x0010, 0x0010, VR::PN, series.patient);
  tags.text(0x0010, 0x0020, VR::LO, series.patient);
  tags.text(0x0010, 0x0030, VR::DA, "");
  tags.text(0x0010, 0x0040, VR::CS, "");
  tags.text(0x0018, 0x0060, VR::DS, "");
  tags.text(0x0018, 0x5100, VR::CS, "");
  tags.text(0x0020, 0x000d, VR::UI, make_uid(series.content, 1));
  tags.text(0x0020, 0x000e, VR::UI, make_uid(series.content, 2));
  tags.text(0x0020, 0x0010, VR::SH, "1");
  tags.text(0x0020, 0x0011, VR::IS, "1");
  tags.text(0x0020, 0x0012, VR::IS, "");
  tags.text(0x0020, 0x0052, VR::UI, make_uid(series.content, 3));
  tags.text(0x0020, 0x1040, VR::LO, "");
}

void describe_slice(const Series& series, int k, const std::string& uid, Tags& tags) {
  using gdcm::VR;
  const Grid& grid = series.ct.grid;
  const Vec3d position = point_at(grid, {0, 0, double(k)}) * 1e3, row = grid.axes.column[0],
              column = grid.axes.column[1];
  tags.text(0x0008, 0x0018, VR::UI, uid);
  tags.text(0x0018, 0x0050, VR::DS, decimal(grid.spacing.z * 1e3));
  tags.text(0x0020, 0x0013, VR::IS, std::to_string(k + 1));
  tags.text(0x0020, 0x0032, VR::DS, decimals({position.x, position.y, position.z}));
  tags.text(0x0020, 0x0037, VR::DS, decimals({row.x, row.y, row.z, column.x, column.y, column.z}));
  tags.integer(0x0028, 0x0002, 1);
  tags.text(0x0028, 0x0004, VR::CS, "MONOCHROME2");
  tags.integer(0x0028, 0x0010, grid.size.y);
  tags.integer(0x0028, 0x0011, grid.size.x);
  tags.text(0x0028, 0x0030, VR::DS, decimals({grid.spacing.y * 1e3, grid.spacing.x * 1e3}));
  tags.integer(0x0028, 0x0100, 16);
  tags.integer(0x0028, 0x0101, 16);
  tags.integer(0x0028, 0x0102, 15);
  tags.integer(0x0028, 0x0103, 1);
  tags.text(0x0028, 0x1050, VR::DS, "40");
  tags.text(0x0028, 0x1051, VR::DS, "400");
  tags.text(0x0028, 0x1052, VR::DS, "0");
  tags.text(0x0028, 0x1053, VR::DS, "1");
  tags.text(0x0028, 0x1054, VR::LO, "HU");
  const std::size_t area = std::size_t(grid.size.x) * std::size_t(grid.size.y);
  tags.bytes(0x7fe0, 0x0010, VR::OW,
             reinterpret_cast<const char*>(series.ct.samples.data() + std::size_t(k) * area), 2 * area);
}

/// Through memory: GDCM ends the program when a file cannot grow.
Status write_slice(const Series& series, int k, const fs::path& file) {
  std::ostringstream bytes;
  gdcm::Writer writer;
  writer.SetStream(bytes);
  gdcm::File& content = writer.GetFile();
  Tags tags(content.GetDataSet());
  const std::string uid = make_uid(series.content, std::uint64_t(k) + 100);
  describe_series(series, tags);
  describe_slice(series, k, uid, tags);
  content.GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  if (!writer.Write()) return Error{fmt::format("{}: cannot be made", file.string())};
  return write_file(file, bytes.str());
}

Status write_slices(const Exec& exec, const fs::path& folder, const Series& series,
                    const Progress& progress) {
  const auto count = std::size_t(series.ct.grid.size.z);
  std::atomic<std::size_t> done{0};
  std::vector<Status> written(count, Status(Done{}));
  std::atomic<bool> failed{false};
  parallel_for(exec, count, [&](std::size_t k) {
    if (failed) return;  // the rest would fail too
    written[k] = write_slice(series, int(k), folder / fmt::format("slice-{:05}.dcm", k + 1));
    if (!written[k]) failed = true;
    if (progress) progress(double(++done) / double(count));
  });
  for (Status& slice : written)
    if (!slice) return std::move(slice);
  return Done{};
}

/// Where the folder will be.
Result<fs::path> check_target(const fs::path& target) {
  Result<fs::path> folder = resolved_goal(target);
  if (!folder) return folder;
  std::error_code failed;
  if (fs::exists(*folder, failed) && !(fs::is_directory(*folder, failed) && fs::is_empty(*folder, failed)))
    return Error{fmt::format(
        "{}: exists already and is not an empty folder; choose another name or remove it", target.string())};
  if (!fs::is_directory(folder->parent_path(), failed))
    return Error{
        fmt::format("{}: the folder {} does not exist", target.string(), folder->parent_path().string())};
  return folder;
}

Status check_extent(const fs::path& target, const Grid& grid) {
  if (grid.size.x <= 65535 && grid.size.y <= 65535 && sample_count(grid) > 0) return Done{};
  return Error{
      fmt::format("{}: {} x {} pixels a slice do not fit DICOM", target.string(), grid.size.x, grid.size.y)};
}

}  // namespace

Status check_dicom_goal(const fs::path& target) {
  if (const Result<fs::path> folder = check_target(target); !folder) return folder.error();
  return Done{};
}

Status write_dicom(const Exec& exec, const fs::path& target, const CtVolume& ct, const std::string& patient,
                   const Progress& progress) {
  const Result<fs::path> folder = check_target(target);
  if (!folder) return folder.error();
  if (Status extent = check_extent(target, ct.grid); !extent) return extent;
  gdcm::Trace::WarningOff();
  std::error_code failed;
  for (const fs::path& left : left_behind(*folder, "partial")) fs::remove_all(left, failed);
  Unfinished partial(*folder);
  if (!fs::create_directory(partial.path(), failed))
    return Error{fmt::format("{}: cannot be made: {}", target.string(), failed.message())};
  const Series series{ct, patient, content_hash(ct, patient)};
  if (Status written = write_slices(exec, partial.path(), series, progress); !written)
    return Error{fmt::format("{}: {}", target.string(), written.error().message)};
  return partial.keep([&]() -> Status {
    if (rename(partial.path().c_str(), folder->c_str()) == 0) return Done{};
    return Error{fmt::format("{}: cannot be given its name: {}", target.string(), std::strerror(errno))};
  });
}

}  // namespace turgor
