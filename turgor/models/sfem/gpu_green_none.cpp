#include "turgor/models/sfem/gpu_green.hpp"

namespace turgor::sfem {

Status fill_green_on_device(const Gpu&, Model&, const Progress&) { return open_gpu().error(); }

}  // namespace turgor::sfem
