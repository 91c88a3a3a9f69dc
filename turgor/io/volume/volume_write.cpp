// Writing of NRRD and MetaImage files: a text header, then compressed samples. Numbers round-trip exactly.
#include "turgor/io/volume/volume_write.hpp"

#include <bit>
#include <new>

#include <fmt/format.h>

#include "turgor/io/files/deflate.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

constexpr bool kBigEndian = std::endian::native == std::endian::big;

struct TypeNames {
  const char *nrrd, *meta;
};
TypeNames names(SampleType type) {
  switch (type) {
    case SampleType::kInt8:
      return {"int8", "MET_CHAR"};
    case SampleType::kUint8:
      return {"uint8", "MET_UCHAR"};
    case SampleType::kInt16:
      return {"int16", "MET_SHORT"};
    case SampleType::kUint16:
      return {"uint16", "MET_USHORT"};
    case SampleType::kInt32:
      return {"int32", "MET_INT"};
    case SampleType::kUint32:
      return {"uint32", "MET_UINT"};
    case SampleType::kInt64:
      return {"int64", "MET_LONG_LONG"};
    case SampleType::kUint64:
      return {"uint64", "MET_ULONG_LONG"};
    case SampleType::kFloat:
      return {"float", "MET_FLOAT"};
    default:
      return {"double", "MET_DOUBLE"};
  }
}

std::string in_brackets(Vec3d v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }
std::string in_words(Vec3d v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }
std::string in_words(Int3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

std::string nrrd_header(const SamplesToWrite& samples) {
  const Grid& grid = samples.grid;
  const bool is_vector = samples.components > 1;
  std::string directions;
  for (int axis = 0; axis < 3; axis++)
    directions += " " + in_brackets(grid.axes.column[axis] * (grid.spacing[axis] * 1e3));
  return fmt::format(
      "NRRD0004\n# Turgor: millimeters, patient frame LPS\ntype: {}\ndimension: {}\n"
      "space: left-posterior-superior\nsizes: {}{}\nspace directions:{}{}\nkinds:{} domain domain domain\n"
      "endian: {}\nencoding: gzip\nspace origin: {}\n\n",
      names(samples.type).nrrd, is_vector ? 4 : 3, is_vector ? fmt::format("{} ", samples.components) : "",
      in_words(grid.size), is_vector ? " none" : "", directions, is_vector ? " vector" : "",
      kBigEndian ? "big" : "little", in_brackets(grid.origin * 1e3));
}

std::string meta_header(const SamplesToWrite& samples, std::size_t packed_size) {
  const Grid& grid = samples.grid;
  const auto& axes = grid.axes.column;
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\nCompressedData = True\n"
      "CompressedDataSize = {}\nTransformMatrix = {} {} {}\nOffset = {}\nCenterOfRotation = 0 0 0\n"
      "ElementSpacing = {}\nDimSize = {}\n{}ElementType = {}\nElementDataFile = LOCAL\n",
      kBigEndian ? "True" : "False", packed_size, in_words(axes[0]), in_words(axes[1]), in_words(axes[2]),
      in_words(grid.origin * 1e3), in_words(grid.spacing * 1e3), in_words(grid.size),
      samples.components > 1 ? fmt::format("ElementNumberOfChannels = {}\n", samples.components) : "",
      names(samples.type).meta);
}

Result<VolumeFormat> format_of_name(const fs::path& path) {
  const std::string name = path.filename().string();
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) return VolumeFormat::kNifti;
  if (name.ends_with(".nrrd")) return VolumeFormat::kNrrd;
  if (name.ends_with(".mha")) return VolumeFormat::kMetaImage;
  return Error{fmt::format("{}: cannot tell the format from the name; expected .nii, .nii.gz, .nrrd or .mha",
                           path.string())};
}

}  // namespace

void write_nrrd(FileWriter& file, const SamplesToWrite& samples, const Exec& exec) {
  file.write(nrrd_header(samples));
  deflate_gzip(exec, {samples.bytes()}, [&file](std::string_view piece) { file.write(piece); });
}

void write_meta_image(FileWriter& file, const SamplesToWrite& samples) {
  std::string packed;  // complete, because the header holds its length
  deflate({samples.bytes()}, Deflate::kZlib, [&packed](std::string_view piece) { packed += piece; });
  file.write(meta_header(samples, packed.size()));
  file.write(packed);
}

Status write_volume_file(const fs::path& path, const SamplesToWrite& samples, const Exec& exec) {
  const Result<VolumeFormat> format = format_of_name(path);
  if (!format) return format.error();
  Result<FileWriter> file = FileWriter::create(path);
  if (!file) return file.error();
  try {
    if (*format == VolumeFormat::kNifti) {
      if (Status written = write_nifti(*file, path, samples, exec); !written) return written;
    } else if (*format == VolumeFormat::kNrrd) {
      write_nrrd(*file, samples, exec);
    } else {
      write_meta_image(*file, samples);
    }
  } catch (const std::bad_alloc&) {
    return Error{fmt::format("{}: cannot be written: not enough memory", path.string())};
  }
  return file->commit();
}

}  // namespace turgor::io

namespace turgor {

Status check_volume_goal(const std::filesystem::path& path) {
  if (const auto format = io::format_of_name(path); !format) return format.error();
  return check_file_goal(path);
}

}  // namespace turgor
