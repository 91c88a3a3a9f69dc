// Writes a CT as a DICOM series: one CT Image Storage file per slice, explicit little endian, stored values =
// HU. Unique identifiers are hashes of the content, so that the same volume gives the same files. A derived
// series keeps patient, study and frame of reference of its origin. [DICOM PS3.3, A.3, C.7.6.1]
#include "turgor/io/dicom/dicom_write.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <gdcmAttribute.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>

#include "turgor/core/hash.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace {

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";

/// A UID below 2.25 (those derived from UUIDs).
std::string make_uid(std::uint64_t content, std::uint64_t index) {
  return fmt::format("2.25.{}{:020}", 1 + content % 999999999ull, detail::mix(content, index + 1));
}

std::uint64_t content_hash(const CtVolume& ct, const DicomOrigin& origin) {
  const Vec3d geometry[] = {ct.grid.spacing, ct.grid.origin, ct.grid.axes.column[0], ct.grid.axes.column[1],
                            ct.grid.axes.column[2]};
  std::uint64_t hash = 0;
  for (const auto& [tag, value] : origin.elements)
    hash = hash_bytes(value.data(), value.size(), hash_bytes(&tag, sizeof tag, hash));
  hash = hash_bytes(&ct.grid.size, sizeof ct.grid.size, hash);
  hash = hash_bytes(geometry, sizeof geometry, hash);
  return hash_values(std::span<const std::int16_t>(ct.samples), hash);
}

struct Series {
  const CtVolume& ct;
  const DicomOrigin& origin;
  std::uint64_t content;

  bool is_derived() const { return !origin.images.empty(); }
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

/// A decimal string has at most 16 characters.
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

/// Required elements that may be empty. [type 2 of PS3.3]
struct Required {
  std::uint32_t tag;
  gdcm::VR::VRType vr;
  const char* otherwise;  // default if the origin has no value
};
using gdcm::VR;
constexpr Required kOfStudy[] = {{0x00080005, VR::CS, "ISO_IR 192"},
                                 {0x00080020, VR::DA, ""},
                                 {0x00080030, VR::TM, ""},
                                 {0x00080050, VR::SH, ""},
                                 {0x00080090, VR::PN, ""},
                                 {0x00081030, VR::LO, ""},
                                 {0x00100010, VR::PN, ""},
                                 {0x00100020, VR::LO, ""},
                                 {0x00100030, VR::DA, ""},
                                 {0x00100040, VR::CS, ""},
                                 {0x00185100, VR::CS, ""},
                                 {0x00200010, VR::SH, "1"},
                                 {0x00201040, VR::LO, ""}};

void describe_study(const Series& series, Tags& tags) {
  const auto said = [&](std::uint32_t tag, const std::string& otherwise) {
    const auto found = series.origin.elements.find(tag);
    return found == series.origin.elements.end() || found->second.empty() ? otherwise : found->second;
  };
  for (const Required& r : kOfStudy)
    tags.text(std::uint16_t(r.tag >> 16), std::uint16_t(r.tag), r.vr, said(r.tag, r.otherwise));
  tags.text(0x0020, 0x000d, VR::UI, said(0x0020000d, make_uid(series.content, 1)));
  tags.text(0x0020, 0x0052, VR::UI, said(0x00200052, make_uid(series.content, 3)));
}

void describe_series(const Series& series, Tags& tags) {
  tags.text(0x0008, 0x0008, VR::CS, "DERIVED\\SECONDARY\\AXIAL");
  tags.text(0x0008, 0x0016, VR::UI, kCtImageStorage);
  tags.text(0x0008, 0x0060, VR::CS, "CT");
  tags.text(0x0008, 0x0070, VR::LO, "Turgor");
  tags.text(0x0008, 0x103e, VR::LO, series.is_derived() ? "Turgor: deformed" : "Turgor volume");
  tags.text(0x0018, 0x0060, VR::DS, "");
  tags.text(0x0020, 0x000e, VR::UI, make_uid(series.content, 2));
  tags.text(0x0020, 0x0011, VR::IS, series.is_derived() ? "1001" : "1");
  tags.text(0x0020, 0x0012, VR::IS, "");
}

/// Image of the origin that is nearest to a slice.
const DicomOrigin::Image& source_of(const Series& series, int k) {
  const Grid& grid = series.ct.grid;
  const Vec3d normal = grid.axes.column[2];
  const double offset = dot(point_at(grid, {0, 0, double(k)}), normal);
  const auto distance = [&](const DicomOrigin::Image& image) {
    return std::abs(dot(image.position, normal) - offset);
  };
  return *std::min_element(series.origin.images.begin(), series.origin.images.end(),
                           [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
}

/// Adds SourceImageSequence with one item.
void name_source(const DicomOrigin::Image& image, gdcm::DataSet& set) {
  gdcm::Item item;
  Tags tags(item.GetNestedDataSet());
  tags.text(0x0008, 0x1150, VR::UI, image.class_uid);
  tags.text(0x0008, 0x1155, VR::UI, image.uid);
  if (image.frame > 0) tags.text(0x0008, 0x1160, VR::IS, std::to_string(image.frame));
  item.SetVLToUndefined();
  gdcm::SmartPointer<gdcm::SequenceOfItems> items = new gdcm::SequenceOfItems;
  items->SetLengthToUndefined();
  items->AddItem(item);
  gdcm::DataElement sequence{gdcm::Tag(0x0008, 0x2112)};
  sequence.SetVR(VR::SQ);
  sequence.SetValue(*items);
  sequence.SetVLToUndefined();
  set.Replace(sequence);
}

void describe_slice(const Series& series, int k, const std::string& uid, Tags& tags) {
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

/// Writes through memory, because GDCM ends the program when a file cannot grow.
Status write_slice(const Series& series, int k, const fs::path& file) {
  std::ostringstream bytes;
  gdcm::Writer writer;
  writer.SetStream(bytes);
  gdcm::File& content = writer.GetFile();
  Tags tags(content.GetDataSet());
  const std::string uid = make_uid(series.content, std::uint64_t(k) + 100);
  describe_study(series, tags);
  describe_series(series, tags);
  describe_slice(series, k, uid, tags);
  if (series.is_derived()) name_source(source_of(series, k), content.GetDataSet());
  content.GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  if (!writer.Write()) return Error{fmt::format("{}: cannot be created", file.string())};
  return write_file(file, bytes.str());
}

Status write_slices(const Exec& exec, const fs::path& folder, const Series& series,
                    const Progress& progress) {
  const auto count = std::size_t(series.ct.grid.size.z);
  std::atomic<std::size_t> done{0};
  std::vector<Status> written(count, Status(Done{}));
  std::atomic<bool> failed{false};
  parallel_for(exec, count, [&](std::size_t k) {
    if (failed) return;  // the others would fail too
    written[k] = write_slice(series, int(k), folder / fmt::format("slice-{:05}.dcm", k + 1));
    if (!written[k]) failed = true;
    if (progress) progress(double(++done) / double(count));
  });
  for (Status& slice : written)
    if (!slice) return std::move(slice);
  return Done{};
}

/// Path of the new folder.
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
  return Error{fmt::format("{}: {} x {} pixels per slice exceed the limit of DICOM", target.string(),
                           grid.size.x, grid.size.y)};
}

}  // namespace

Status check_dicom_goal(const fs::path& target) {
  if (const Result<fs::path> folder = check_target(target); !folder) return folder.error();
  return Done{};
}

DicomOrigin patient_alone(const std::string& name) { return {{{0x00100010, name}, {0x00100020, name}}, {}}; }

Status write_dicom(const Exec& exec, const fs::path& target, const CtVolume& ct, const DicomOrigin& origin,
                   const Progress& progress) {
  const Result<fs::path> folder = check_target(target);
  if (!folder) return folder.error();
  if (Status extent = check_extent(target, ct.grid); !extent) return extent;
  gdcm::Trace::WarningOff();
  std::error_code failed;
  for (const fs::path& leftover : leftovers_beside(*folder, "partial")) fs::remove_all(leftover, failed);
  Unfinished partial(*folder);
  if (!fs::create_directory(partial.path(), failed))
    return Error{fmt::format("{}: cannot be created: {}", target.string(), failed.message())};
  partial.hold();
  const Series series{ct, origin, content_hash(ct, origin)};
  if (Status written = write_slices(exec, partial.path(), series, progress); !written)
    return Error{fmt::format("{}: {}", target.string(), written.error().message)};
  return partial.keep([&]() -> Result<fs::path> {
    if (rename(partial.path().c_str(), folder->c_str()) == 0) return *folder;
    return Error{fmt::format("{}: cannot be renamed: {}", target.string(), std::strerror(errno))};
  });
}

}  // namespace turgor
