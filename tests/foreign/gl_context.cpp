#ifdef PLUMB_WITH_OPENGL

#define EGL_EGLEXT_PROTOTYPES
#define GL_GLEXT_PROTOTYPES
#include "tests/foreign/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>

#include <stdexcept>

namespace plumb::foreign::gl {

namespace {

struct GlFormat {
    const char* name;  // VkFormat without VK_FORMAT_
    GLenum internal, format, type;
    int bytes;
};

constexpr GlFormat known_formats[] = {
    {"R32_SFLOAT", GL_R32F, GL_RED, GL_FLOAT, 4},
    {"R32G32B32A32_SFLOAT", GL_RGBA32F, GL_RGBA, GL_FLOAT, 16},
    {"R16G16B16A16_SFLOAT", GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8},
    {"A2B10G10R10_UNORM_PACK32", GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_INT_2_10_10_10_REV, 4},
    {"D32_SFLOAT", GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4},
};

const GlFormat& format_of(const std::string& name) {
    for (const GlFormat& f : known_formats)
        if (name == f.name) return f;
    throw std::runtime_error("OpenGL: no format " + name);
}

void require(bool is_so, const std::string& what) {
    if (!is_so) throw std::runtime_error("OpenGL: " + what);
}

GLuint compile(GLenum kind, const std::string& text) {
    const GLuint shader = glCreateShader(kind);
    const char* source = text.c_str();
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint compiled = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    char log[2000] = "";
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    require(compiled, log);
    return shader;
}

GLuint link(const std::string& vertex, const std::string& fragment) {
    const GLuint program = glCreateProgram(), v = compile(GL_VERTEX_SHADER, vertex),
                 f = compile(GL_FRAGMENT_SHADER, fragment);
    glAttachShader(program, v), glAttachShader(program, f);
    glLinkProgram(program);
    glDeleteShader(v), glDeleteShader(f);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    require(linked, "shaders do not link");
    return program;
}

GLuint make_texture(GLenum unit, const Sampled& sampled) {
    const GlFormat& f = format_of(sampled.texture.format);
    GLuint id = 0;
    glGenTextures(1, &id);
    glActiveTexture(unit);
    glBindTexture(GL_TEXTURE_2D, id);
    glTexImage2D(GL_TEXTURE_2D, 0, GLint(f.internal), sampled.texture.width, sampled.texture.height, 0, f.format,
                 f.type, sampled.texture.bytes.data());
    const GLint filter = sampled.filter == Filter::linear ? GL_LINEAR : GL_NEAREST;
    const GLint wrap = sampled.border == Border::edge ? GL_CLAMP_TO_EDGE : GL_CLAMP_TO_BORDER;
    const float border = sampled.border == Border::white ? 1.0f : 0.0f;
    const float colour[4] = {border, border, border, border};
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, colour);
    if (sampled.compares) glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    return id;
}

void set(GLuint program, const Uniform& u) {
    const GLint at = glGetUniformLocation(program, u.name.c_str());
    const GLsizei n = u.components > 0 ? GLsizei(u.values.size()) / u.components : 1;
    switch (u.components) {
        case 0:
            return glUniform1i(at, GLint(u.values[0]));
        case 1:
            return glUniform1fv(at, n, u.values.data());
        case 2:
            return glUniform2fv(at, n, u.values.data());
        case 3:
            return glUniform3fv(at, n, u.values.data());
        case 16:
            return glUniformMatrix4fv(at, n, GL_FALSE, u.values.data());
        default:
            throw std::runtime_error("OpenGL: no uniform of that many components");
    }
}

// Displays without a window: Mesa's, then one of each device that EGL lists, as other drivers have it.
std::vector<EGLDisplay> displays() {
    std::vector<EGLDisplay> out = {eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr)};
    const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    EGLDeviceEXT devices[16];
    EGLint n = 0;
    if (query && query(16, devices, &n))
        for (EGLint i = 0; i < n; ++i)
            out.push_back(eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
    return out;
}

}  // namespace

struct Context::Handles {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    explicit Handles(EGLDisplay of) : display(of) {
        require(display != EGL_NO_DISPLAY, "EGL has no display without a window");
        require(eglInitialize(display, nullptr, nullptr), "EGL does not start");
        require(eglBindAPI(EGL_OPENGL_API), "EGL has no OpenGL");
        const EGLint wanted[] = {
            EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
        context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
        require(context != EGL_NO_CONTEXT, "there is no context of OpenGL 4.5");
        make_current();
        // A core profile draws nothing without one.
        GLuint vertices = 0;
        glGenVertexArrays(1, &vertices);
        glBindVertexArray(vertices);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1), glPixelStorei(GL_PACK_ALIGNMENT, 1);
    }
    void make_current() const {
        require(eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context), "the context needs a surface");
    }
    ~Handles() {
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
        eglTerminate(display);
    }
    Handles(const Handles&) = delete;
    Handles& operator=(const Handles&) = delete;
};

Context::Context(const std::string& name) {
    std::string met;
    for (const EGLDisplay display : displays()) {
        try {
            handles_ = std::make_unique<Handles>(display);
            if (device().find(name) != std::string::npos) return;
            met += (met.empty() ? "" : "; ") + device();
        } catch (const std::runtime_error& error) {
            met += (met.empty() ? "" : "; ") + std::string(error.what());
        }
        handles_.reset();
    }
    throw std::runtime_error("no " + name + " for OpenGL: " + met);
}
Context::~Context() = default;

std::string Context::device() const { return reinterpret_cast<const char*>(glGetString(GL_RENDERER)); }

std::vector<Texture> Context::draw(glm::ivec2 size, const std::string& vertex, const std::string& fragment,
                                   const std::vector<Sampled>& textures, const std::vector<Uniform>& uniforms,
                                   const std::vector<std::string>& formats) {
    handles_->make_current();  // a Vulkan device that went may have taken it along
    const GLuint program = link(vertex, fragment);
    glUseProgram(program);
    std::vector<GLuint> ids;
    for (const Sampled& t : textures) {
        glUniform1i(glGetUniformLocation(program, t.name.c_str()), GLint(ids.size()));
        ids.push_back(make_texture(GLenum(GL_TEXTURE0 + ids.size()), t));
    }
    for (const Uniform& u : uniforms) set(program, u);

    GLuint frame = 0;
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    std::vector<GLuint> targets(formats.size());
    std::vector<GLenum> attachments;
    glGenRenderbuffers(GLsizei(targets.size()), targets.data());
    for (std::size_t i = 0; i < formats.size(); ++i) {
        attachments.push_back(GLenum(GL_COLOR_ATTACHMENT0 + i));
        glBindRenderbuffer(GL_RENDERBUFFER, targets[i]);
        glRenderbufferStorage(GL_RENDERBUFFER, format_of(formats[i]).internal, size.x, size.y);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachments[i], GL_RENDERBUFFER, targets[i]);
    }
    glDrawBuffers(GLsizei(attachments.size()), attachments.data());
    require(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE, "the targets are not complete");
    glViewport(0, 0, size.x, size.y);
    glDrawArrays(GL_TRIANGLES, 0, 3);

    std::vector<Texture> out;
    for (std::size_t i = 0; i < formats.size(); ++i) {
        const GlFormat& f = format_of(formats[i]);
        out.push_back(
            {formats[i], size.x, size.y, std::vector<unsigned char>(std::size_t(size.x * size.y * f.bytes)), true});
        glReadBuffer(attachments[i]);
        glReadPixels(0, 0, size.x, size.y, f.format, f.type, out.back().bytes.data());
    }
    const GLenum error = glGetError();
    glDeleteFramebuffers(1, &frame);
    glDeleteRenderbuffers(GLsizei(targets.size()), targets.data());
    glDeleteTextures(GLsizei(ids.size()), ids.data());
    glDeleteProgram(program);
    require(error == GL_NO_ERROR, "error " + std::to_string(error));
    return out;
}

}  // namespace plumb::foreign::gl

#endif
