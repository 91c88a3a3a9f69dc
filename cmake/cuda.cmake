# Bodies on NVIDIA GPUs: nvcc compiles every .cu of the engine to PTX for compute capability 7.5 or higher, and the driver compiles it
# at run time. Programs start without a driver. Without nvcc, *_none.cpp replace the .cu files and report what is missing.
# Uses custom commands, because CMake 3.25 omits -std=c++20 for nvcc 13 and turgor_flags apply only to C++.
set(TURGOR_CUDA AUTO CACHE STRING "Bodies on GPUs (nvcc 12 or newer): ON, OFF, or AUTO if it is found")

set(nvcc_version 0)
if(TURGOR_CUDA)
  find_program(TURGOR_NVCC nvcc HINTS ENV CUDA_PATH /usr/local/cuda PATH_SUFFIXES bin)
  if(TURGOR_NVCC)
    execute_process(COMMAND ${TURGOR_NVCC} --version OUTPUT_VARIABLE nvcc_output)
    if(nvcc_output MATCHES "release ([0-9.]+)")
      set(nvcc_version ${CMAKE_MATCH_1})
    endif()
    get_filename_component(cuda_folder ${TURGOR_NVCC} DIRECTORY)
    find_library(TURGOR_CUDART cudart_static HINTS ${cuda_folder}/../lib64 ${cuda_folder}/../lib)
  endif()
endif()

set(with_cuda FALSE)
if(TURGOR_CUDA AND TURGOR_CUDART AND nvcc_version VERSION_GREATER_EQUAL 12)
  set(with_cuda TRUE)
elseif(TURGOR_CUDA AND NOT TURGOR_CUDA STREQUAL "AUTO")
  message(FATAL_ERROR "TURGOR_CUDA=${TURGOR_CUDA} needs nvcc 12 or newer and cudart_static; found ${TURGOR_NVCC}, version ${nvcc_version}")
endif()

set(nvcc_flags -std=c++20 -O3 --expt-relaxed-constexpr -ftz=true -Werror cross-execution-space-call -Xcompiler -fPIC,-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=
    -gencode arch=compute_75,code=compute_75)
if(TURGOR_SAME_BITS)
  list(APPEND nvcc_flags -fmad=false)
endif()

# Adds the .cu files of these folders to a library instead of their *_none.cpp replacements.
function(turgor_kernels target)
  if(NOT with_cuda)
    return()
  endif()
  list(TRANSFORM ARGN APPEND "/*.cu" OUTPUT_VARIABLE patterns)
  file(GLOB_RECURSE kernels RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS ${patterns})
  foreach(name IN LISTS kernels)
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${name})
    set(object ${CMAKE_CURRENT_BINARY_DIR}/${name}.o)
    get_filename_component(folder ${object} DIRECTORY)
    file(MAKE_DIRECTORY ${folder})
    add_custom_command(OUTPUT ${object} DEPENDS ${source} DEPFILE ${object}.d COMMENT "Building CUDA object ${name}.o" VERBATIM
      COMMAND ${TURGOR_NVCC} ${nvcc_flags} -I${PROJECT_SOURCE_DIR} -MD -MF ${object}.d -MT ${object} -c ${source} -o ${object})
    target_sources(${target} PRIVATE ${object})
  endforeach()
  if(kernels)
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources EXCLUDE REGEX "_none\\.cpp$")
    set_target_properties(${target} PROPERTIES SOURCES "${sources}")
    target_link_libraries(${target} PRIVATE ${TURGOR_CUDART} ${CMAKE_DL_LIBS} rt)
  endif()
endfunction()
