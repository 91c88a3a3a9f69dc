#include "turgor/view/gl.hpp"

#include <fmt/format.h>

namespace turgor {

namespace {

Result<GLuint> compile(GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good) return shader;
  char log[1024] = {};
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glDeleteShader(shader);
  return Error{fmt::format("cannot draw: glCompileShader failed: {}", log)};
}

// Location of a uniform in the current program.
GLint uniform_location(const char* name) {
  GLint program = 0;
  glGetIntegerv(GL_CURRENT_PROGRAM, &program);
  return glGetUniformLocation(GLuint(program), name);
}

}  // namespace

Result<GLuint> link_program(const char* vertex_source, const char* fragment_source) {
  const Result<GLuint> vertex = compile(GL_VERTEX_SHADER, vertex_source);
  if (!vertex) return vertex.error();
  const Result<GLuint> fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
  if (!fragment) return fragment.error();
  const GLuint program = glCreateProgram();
  for (const GLuint shader : {*vertex, *fragment}) {
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  GLint good = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  if (good) return program;
  return Error{"cannot draw: glLinkProgram failed"};
}

void set_uniform(const char* name, Vec3 v) { glUniform3f(uniform_location(name), v.x, v.y, v.z); }
void set_uniform(const char* name, Vec3 v, float w) { glUniform4f(uniform_location(name), v.x, v.y, v.z, w); }
void set_uniform(const char* name, float a, float b) { glUniform2f(uniform_location(name), a, b); }
void set_uniform(const char* name, float a) { glUniform1f(uniform_location(name), a); }
void set_uniform(const char* name, int a) { glUniform1i(uniform_location(name), a); }
void set_uniform(const char* name, const std::array<float, 16>& columns) {
  glUniformMatrix4fv(uniform_location(name), 1, GL_FALSE, columns.data());
}
void set_texture(const char* name, int unit, GLuint texture, GLenum kind) {
  glActiveTexture(GLenum(GL_TEXTURE0 + unit));
  glBindTexture(kind, texture);
  set_uniform(name, unit);
}

GLuint new_texture(GlObjects& objects, GLint format, GLenum layout, GLenum type, int width, int height) {
  const GLuint texture = objects.new_texture();
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, layout, type, nullptr);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  return texture;
}

GLuint new_multisample_texture(GlObjects& objects, GLenum format, int samples, int width, int height) {
  const GLuint texture = objects.new_texture();
  glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, texture);
  glTexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, samples, format, width, height, GL_TRUE);
  return texture;
}

bool attach_textures(GLuint framebuffer, GLenum kind, std::initializer_list<GLuint> colors, GLuint depth,
                     GLenum point) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  std::vector<GLenum> names;
  for (const GLuint color : colors) {
    names.push_back(GLenum(GL_COLOR_ATTACHMENT0 + names.size()));
    glFramebufferTexture2D(GL_FRAMEBUFFER, names.back(), kind, color, 0);
  }
  if (depth) glFramebufferTexture2D(GL_FRAMEBUFFER, point, kind, depth, 0);
  glDrawBuffers(GLsizei(names.size()), names.data());
  return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

}  // namespace turgor
