# Rules for `cmake --install`: everything or one sentence. Components: program (turgor, turgor-read), cpp (libraries, headers, package),
# c (libturgor_c, turgor.h) and mpi (turgor_mpi).

# Ends the installation of a component before its first file if one of these targets is not built. The targets may be declared later.
# With ONLY_ALONE it ends only the installation of this component alone.
function(turgor_require_built component)
  cmake_parse_arguments(REQUIRE "ONLY_ALONE" "" "" ${ARGN})
  set(checks)
  foreach(target IN LISTS REQUIRE_UNPARSED_ARGUMENTS)
    string(APPEND checks "$<$<TARGET_EXISTS:${target}>:list(APPEND turgor_files \"$<TARGET_FILE:${target}>\")>\n")
  endforeach()
  set(applies)
  if(REQUIRE_ONLY_ALONE)
    set(applies "CMAKE_INSTALL_COMPONENT STREQUAL \"${component}\" AND")
  endif()
  install(CODE "set(turgor_files)\n${checks}
  foreach(turgor_file IN LISTS turgor_files)
    if(${applies} NOT EXISTS \"\${turgor_file}\")
      message(FATAL_ERROR \"nothing was installed: \${turgor_file} is not built; run `cmake --build ${PROJECT_BINARY_DIR}` first\")
    endif()
  endforeach()" COMPONENT ${component})
endfunction()

# Leaves out the rules that follow in this folder, and says so, if the target is not built.
function(turgor_install_if_built component target)
  install(CODE "if(NOT EXISTS \"$<TARGET_FILE:${target}>\")
    message(STATUS \"$<TARGET_FILE_NAME:${target}> is not built and not installed; `cmake --build ${PROJECT_BINARY_DIR} --target ${target}` builds it\")
    return()
  endif()" COMPONENT ${component})
endfunction()
