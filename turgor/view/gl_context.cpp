#include "turgor/view/gl_context.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <fmt/format.h>

namespace turgor {

namespace {

struct EglContext {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

Error egl_error(const char* call) {
  return {
      fmt::format("cannot draw: {} failed with EGL error {:#x}; is an OpenGL driver installed "
                  "(Debian: libgl1-mesa-dri)?",
                  call, eglGetError())};
}

bool can_load(const char* library) {
  void* handle = dlopen(library, RTLD_LAZY | RTLD_LOCAL);  // stays loaded for libepoxy
  return handle != nullptr;
}

// libepoxy ends the process if these libraries are missing.
Status check_libraries() {
  if (!can_load("libEGL.so.1"))
    return Error{"cannot draw: libEGL.so.1 is missing (Debian: apt-get install libegl1)"};
  if (!can_load("libGL.so.1") && !can_load("libOpenGL.so.0"))
    return Error{"cannot draw: libGL.so.1 and libOpenGL.so.0 are missing (Debian: apt-get install libgl1)"};
  return Done{};
}

bool has_word(const char* words, std::string_view word) {
  std::string_view rest = words ? words : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == word) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

EGLDisplay initialized(EGLDisplay display) {
  return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
}

// GPUs first; NVIDIA's drivers offer only devices.
EGLDisplay open_device() {
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (!eglQueryDevicesEXT(EGLint(devices.size()), devices.data(), &count)) return EGL_NO_DISPLAY;
  for (EGLint i = 0; i < count; i++) {
    const EGLDisplay display =
        initialized(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)], nullptr));
    if (display != EGL_NO_DISPLAY) return display;
  }
  return EGL_NO_DISPLAY;
}

EGLDisplay open_display() {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!has_word(extensions, "EGL_EXT_platform_base")) return EGL_NO_DISPLAY;
  EGLDisplay display = EGL_NO_DISPLAY;
  if (has_word(extensions, "EGL_MESA_platform_surfaceless"))
    display = initialized(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
  if (display == EGL_NO_DISPLAY && has_word(extensions, "EGL_EXT_platform_device") &&
      has_word(extensions, "EGL_EXT_device_enumeration"))
    display = open_device();
  return display;
}

Result<EglContext> create_context() {
  if (const Status libraries = check_libraries(); !libraries) return libraries.error();
  EglContext egl;
  egl.display = open_display();
  if (egl.display == EGL_NO_DISPLAY) return egl_error("opening an EGL display without a screen");
  if (!eglBindAPI(EGL_OPENGL_API)) return egl_error("eglBindAPI(EGL_OPENGL_API)");
  const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                      EGL_NONE};
  EGLConfig config = nullptr;
  EGLint config_count = 0;
  if (!eglChooseConfig(egl.display, config_attributes, &config, 1, &config_count) || config_count == 0)
    return egl_error("eglChooseConfig");
  const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                       3,
                                       EGL_CONTEXT_MINOR_VERSION,
                                       3,
                                       EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                       EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                       EGL_NONE};
  egl.context = eglCreateContext(egl.display, config, EGL_NO_CONTEXT, context_attributes);
  if (egl.context == EGL_NO_CONTEXT) return egl_error("eglCreateContext (OpenGL 3.3 core)");
  return egl;
}

std::mutex& gl_mutex() {
  static std::mutex mutex;
  return mutex;
}

// The mutex must be held.
const Result<EglContext>& the_context() {
  static const Result<EglContext> context = create_context();
  return context;
}

}  // namespace

CurrentGl::~CurrentGl() {
  if (lock_) eglMakeCurrent(the_context()->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

Result<CurrentGl> hold_gl() {
  std::unique_lock lock(gl_mutex());
  const Result<EglContext>& egl = the_context();
  if (!egl) return egl.error();
  if (!eglMakeCurrent(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context))
    return egl_error("eglMakeCurrent");
  return CurrentGl(std::move(lock));
}

}  // namespace turgor
