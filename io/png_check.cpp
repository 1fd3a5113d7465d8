#include "io/png_check.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {
namespace {

// Deflate packs 258 bytes into two bits at best (RFC 1951, 3.2.5): bytes of a row are taken only where a file may fill them.
constexpr std::size_t most_inflated = 1032;

// Plain data: libpng's errors jump over the frames below, so nothing there may need a destructor.
struct Reader {
    const unsigned char* next;
    std::size_t left, size;
    png_structp png = nullptr;
    png_infop info = nullptr;
    png_bytep row = nullptr;
    std::jmp_buf out = {};
    char fault[200] = "";
};

[[noreturn]] void stop(png_structp png, png_const_charp message) {
    Reader& reader = *static_cast<Reader*>(png_get_error_ptr(png));
    std::snprintf(reader.fault, sizeof reader.fault, "%s", message);
    std::longjmp(reader.out, 1);
}

void pass_over(png_structp, png_const_charp) {}  // warnings

void give(png_structp png, png_bytep to, std::size_t bytes) {
    Reader& reader = *static_cast<Reader*>(png_get_io_ptr(png));
    if (bytes > reader.left) png_error(png, "the picture is cut off");
    std::memcpy(to, reader.next, bytes);
    reader.next += bytes;
    reader.left -= bytes;
}

// One row is in memory at a time. libpng's own limits hold, 1,000,000 pixels a side: OpenImageIO's reader has them too.
void read_all(Reader& reader) {
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, stop, pass_over);
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) throw std::bad_alloc();
    png_set_read_fn(reader.png, &reader, give);
    png_read_info(reader.png, reader.info);
    const int passes = png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    const png_uint_32 height = png_get_image_height(reader.png, reader.info);
    if (png_get_rowbytes(reader.png, reader.info) > most_inflated * reader.size / height)
        png_error(reader.png, "IHDR: the file is too short for so many pixels");
    reader.row = static_cast<png_bytep>(png_calloc(reader.png, png_get_rowbytes(reader.png, reader.info)));
    for (int pass = 0; pass < passes; ++pass)
        for (png_uint_32 y = 0; y < height; ++y) png_read_row(reader.png, reader.row, nullptr);
    png_read_end(reader.png, reader.info);
}

void read_or_stop(Reader& reader) {
    if (setjmp(reader.out) == 0) read_all(reader);
    if (reader.png) png_free(reader.png, reader.row);
    png_destroy_read_struct(&reader.png, &reader.info, nullptr);
}

}  // namespace

void read_png_through(const std::string& path, const std::vector<unsigned char>& file) {
    Reader reader{file.data(), file.size(), file.size()};
    read_or_stop(reader);
    if (*reader.fault) throw InputError(shown(path), "PNG", printable(reader.fault, sizeof reader.fault));
}

}  // namespace plumb::io
