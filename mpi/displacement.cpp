#include "mpi/displacement.hpp"

#include <bit>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "turgor/io/files/file.hpp"

namespace turgor::mpi {

namespace {

constexpr const char* kSamples = "displacement.raw";

std::string words(Vec3d v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

std::string header(const Grid& nodes) {
  const auto& axes = nodes.axes.column;
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\nCompressedData = "
      "False\n"
      "TransformMatrix = {} {} {}\nOffset = {}\nCenterOfRotation = 0 0 0\nElementSpacing = {}\nDimSize = {} "
      "{} {}\n"
      "ElementNumberOfChannels = 3\nElementType = MET_FLOAT\nElementDataFile = {}\n",
      std::endian::native == std::endian::big ? "True" : "False", words(axes[0]), words(axes[1]),
      words(axes[2]), words(nodes.origin * 1e3), words(nodes.spacing * 1e3), nodes.size.x, nodes.size.y,
      nodes.size.z, kSamples);
}

/// Displacements of one layer [mm], i fastest.
std::vector<Vec3> layer_in_mm(const Subdomain& subdomain, int layer) {
  const Lattice& l = subdomain.model.anatomy.lattice;
  std::vector<Vec3> values;
  for (int j = 0; j < l.size.y; j++)
    for (int i = 0; i < l.size.x; i++) {
      const int slot = node_slot(l, i, j, layer);
      const bool solid = lattice::is_solid(subdomain.model, subdomain.state.cuts, slot);
      values.push_back(solid ? Vec3(subdomain.model.anatomy.grid.axes *
                                    (Vec3d(subdomain.state.motion.u[std::size_t(slot)]) * 1e3))
                             : Vec3{});
    }
  return values;
}

}  // namespace

Status write_displacement(const Subdomain& subdomain, const Grid& nodes,
                          const std::filesystem::path& folder) {
  if (subdomain.ranks.rank == 0)
    if (const Status written = write_file(folder / "displacement.mhd", header(nodes)); !written)
      return written;
  const std::filesystem::path path = folder / kSamples;
  const auto failure = [&] {
    return Error{fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno))};
  };
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return failure();
  Status status = Done{};
  for (int k = subdomain.model.anatomy.owned.begin; k < subdomain.model.anatomy.owned.end && status; k++) {
    const std::vector<Vec3> values = layer_in_mm(subdomain, k);
    const std::size_t size = values.size() * sizeof(Vec3);
    const auto* bytes = reinterpret_cast<const char*>(values.data());
    for (std::size_t done = 0; done < size && status;) {
      const auto at = off_t(std::size_t(k + subdomain.model.anatomy.lattice.first) * size + done);
      const ssize_t count = pwrite(file, bytes + done, size - done, at);
      if (count > 0)
        done += std::size_t(count);
      else if (errno != EINTR)
        status = failure();
    }
  }
  if (close(file) != 0 && status) status = failure();
  return status;
}

}  // namespace turgor::mpi
