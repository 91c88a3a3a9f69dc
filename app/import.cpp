#include "app/commands.hpp"

namespace turgor {

void add_import_command(CLI::App&, Global&) {}

}  // namespace turgor
