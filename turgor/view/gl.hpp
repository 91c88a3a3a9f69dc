// Small OpenGL helpers: objects with automatic release, programs from source, uniforms by name, render
// targets. The context must be held (gl_context.hpp).
#pragma once

#include <array>
#include <initializer_list>
#include <vector>

#include <epoxy/gl.h>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// Releases the OpenGL objects of a picture.
struct GlObjects {
  std::vector<GLuint> textures, buffers, framebuffers, arrays;

  GlObjects() = default;
  GlObjects(const GlObjects&) = delete;
  GlObjects& operator=(const GlObjects&) = delete;
  ~GlObjects() {
    glDeleteTextures(GLsizei(textures.size()), textures.data());
    glDeleteBuffers(GLsizei(buffers.size()), buffers.data());
    glDeleteFramebuffers(GLsizei(framebuffers.size()), framebuffers.data());
    glDeleteVertexArrays(GLsizei(arrays.size()), arrays.data());
  }
  GLuint new_texture() { return glGenTextures(1, &textures.emplace_back()), textures.back(); }
  GLuint new_buffer() { return glGenBuffers(1, &buffers.emplace_back()), buffers.back(); }
  GLuint new_framebuffer() { return glGenFramebuffers(1, &framebuffers.emplace_back()), framebuffers.back(); }
  GLuint new_array() { return glGenVertexArrays(1, &arrays.emplace_back()), arrays.back(); }
};

/// Error: the compiler's log.
Result<GLuint> link_program(const char* vertex_source, const char* fragment_source);

/// Sets a uniform of the current program; unused names are ignored.
void set_uniform(const char* name, Vec3 v);
void set_uniform(const char* name, Vec3 v, float w);
void set_uniform(const char* name, float a, float b);
void set_uniform(const char* name, float a);
void set_uniform(const char* name, int a);
void set_uniform(const char* name, const std::array<float, 16>& columns);
void set_texture(const char* name, int unit, GLuint texture, GLenum kind = GL_TEXTURE_2D);

/// Texture with one sample per pixel, unfiltered.
GLuint new_texture(GlObjects& objects, GLint format, GLenum layout, GLenum type, int width, int height);
/// Texture with several samples per pixel.
GLuint new_multisample_texture(GlObjects& objects, GLenum format, int samples, int width, int height);
/// Attaches these textures to a framebuffer; depth 0 = none. `point` is GL_DEPTH_STENCIL_ATTACHMENT for a
/// depth texture with stencil. False if OpenGL does not accept them.
bool attach_textures(GLuint framebuffer, GLenum kind, std::initializer_list<GLuint> colors, GLuint depth,
                     GLenum point = GL_DEPTH_ATTACHMENT);

}  // namespace turgor
