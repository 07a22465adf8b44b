#include "apps/window/gl/gl_objects.h"

#include <array>
#include <string>

#include "aula/exception.h"

namespace aula {

namespace {

GLuint compiled(GLenum kind, const char* text) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok == 0) {
        std::array<char, 512> log{};
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw InputError(std::string("window: the graphics driver refuses a shader: ") +
                         log.data());
    }
    return shader;
}

}  // namespace

GlProgram::GlProgram(const char* vertex, const char* fragment) : program_(glCreateProgram()) {
    const GLuint parts[] = {compiled(GL_VERTEX_SHADER, vertex),
                            compiled(GL_FRAGMENT_SHADER, fragment)};
    for (const GLuint part : parts) glAttachShader(program_, part);
    glLinkProgram(program_);
    for (const GLuint part : parts) glDeleteShader(part);
    GLint ok = 0;
    glGetProgramiv(program_, GL_LINK_STATUS, &ok);
    if (ok == 0) throw InputError("window: the graphics driver cannot link a shader");
}

GlProgram::~GlProgram() { glDeleteProgram(program_); }

GlVertices::GlVertices(std::initializer_list<int> attributes) {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &buffer_);
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    for (const int size : attributes) floats_ += static_cast<std::size_t>(size);
    std::size_t offset = 0;
    GLuint location = 0;
    for (const int size : attributes) {
        glEnableVertexAttribArray(location);
        glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE,
                              static_cast<GLsizei>(floats_ * sizeof(float)),
                              reinterpret_cast<const void*>(offset * sizeof(float)));
        offset += static_cast<std::size_t>(size);
        ++location;
    }
}

GlVertices::~GlVertices() {
    glDeleteBuffers(1, &buffer_);
    glDeleteVertexArrays(1, &array_);
}

void GlVertices::set(std::span<const float> data, GLenum usage) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size_bytes()), data.data(), usage);
    count_ = static_cast<GLsizei>(data.size() / floats_);
}

void GlVertices::draw(GLenum mode) const {
    if (count_ == 0) return;
    glBindVertexArray(array_);
    glDrawArrays(mode, 0, count_);
}

}  // namespace aula
