#include "turgor/sim/bodies/lattice/load_ct.hpp"

#include <fmt/format.h>

#include "turgor/core/hash.hpp"

namespace turgor {

Result<LoadedCt> load_ct(const Exec& exec, const CtSource& source, const Progress& progress) {
  if (source.given) return LoadedCt{*source.given, std::nullopt, {}, {}, {}};
  if (source.phantom) {
    LoadedCt loaded;
    LabelVolume labels;
    loaded.volume = make_phantom(exec, *source.phantom, &labels, progress);
    loaded.labels = std::move(labels);
    return loaded;
  }
  Result<CtFile> file = read_ct(exec, source.file, {source.series, progress});
  if (!file) return file.error();
  return LoadedCt{std::move(file->ct), std::nullopt, std::move(file->notes), std::move(file->origin),
                  std::move(file->series)};
}

std::uint64_t content_hash(const CtVolume& ct) {
  std::uint64_t hash = hash_values(std::span(ct.samples));
  const Grid& g = ct.grid;
  hash = hash_bytes(&g.size, sizeof g.size, hash);
  hash = hash_bytes(&g.spacing, sizeof g.spacing, hash);
  hash = hash_bytes(&g.origin, sizeof g.origin, hash);
  return hash_bytes(&g.axes, sizeof g.axes, hash);
}

}  // namespace turgor
