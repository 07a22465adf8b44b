#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <initializer_list>
#include <span>
#include <utility>

namespace aula {

/// A linked pair of shaders. The constructor throws InputError if the driver cannot build it.
class GlProgram {
 public:
    GlProgram(const char* vertex, const char* fragment);
    ~GlProgram();
    GlProgram(const GlProgram&) = delete;
    GlProgram& operator=(const GlProgram&) = delete;

    void use() const { glUseProgram(program_); }
    GLint uniform(const char* name) const { return glGetUniformLocation(program_, name); }

 private:
    GLuint program_;
};

/// Vertex data in a buffer, drawn as triangles, lines or points.
class GlVertices {
 public:
    /// Sizes of the vertex attributes in floats, in the order of their locations.
    explicit GlVertices(std::initializer_list<int> attributes);
    ~GlVertices();
    GlVertices(const GlVertices&) = delete;
    GlVertices& operator=(const GlVertices&) = delete;

    void set(std::span<const float> data, GLenum usage = GL_STATIC_DRAW);
    void draw(GLenum mode) const;
    bool empty() const { return count_ == 0; }

 private:
    GLuint array_ = 0;
    GLuint buffer_ = 0;
    std::size_t floats_ = 0;  ///< per vertex
    GLsizei count_ = 0;
};

}  // namespace aula
