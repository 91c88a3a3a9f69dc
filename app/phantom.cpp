#include "app/commands.hpp"

namespace turgor {

void add_phantom_command(CLI::App&, Global&) {}

}  // namespace turgor
