#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/ground_grid_files.h"

namespace grouser {

namespace {

/// Everything that the reading needs lives outside of the frame that libpng jumps back to.
struct Reading {
  std::FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
  png_uint_32 width = 0, height = 0;
  int depth = 0, colour = 0;
  std::vector<png_byte> bytes;
  std::vector<png_bytep> rows;
  std::string problem;

  Reading() = default;
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
  ~Reading() {
    if (png) png_destroy_read_struct(&png, info ? &info : nullptr, nullptr);
    if (file) std::fclose(file);
  }
};

void on_error(png_structp png, png_const_charp message) {
  static_cast<Reading*>(png_get_error_ptr(png))->problem =
      std::string("the PNG is cut off or damaged (") + message + "); export it again, as 16-bit grey";
  std::longjmp(png_jmpbuf(png), 1);
}
void on_warning(png_structp, png_const_charp) {}

const char* colour_name(int c) {
  return c == PNG_COLOR_TYPE_GRAY         ? "grey"
         : c == PNG_COLOR_TYPE_GRAY_ALPHA ? "grey with alpha"
         : c == PNG_COLOR_TYPE_PALETTE    ? "palette"
         : c == PNG_COLOR_TYPE_RGB        ? "RGB"
                                          : "RGB with alpha";
}

bool read_header(Reading& r) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_init_io(r.png, r.file);
  png_set_sig_bytes(r.png, 8);
  png_read_info(r.png, r.info);
  png_get_IHDR(r.png, r.info, &r.width, &r.height, &r.depth, &r.colour, nullptr, nullptr, nullptr);
  return true;
}

bool read_pixels(Reading& r) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_set_interlace_handling(r.png);
  png_read_update_info(r.png, r.info);
  png_read_image(r.png, r.rows.data());
  png_read_end(r.png, nullptr);
  return true;
}

}  // namespace

HeightGrid read_height_png(const std::filesystem::path& path, double spacing, double lowest, double highest) {
  auto fail = [&](const std::string& message) { throw ConfigError(path.string(), 0, 0, message); };
  Reading r;
  r.file = std::fopen(path.c_str(), "rb");
  if (!r.file) fail("cannot read the file");
  png_byte signature[8];
  if (std::fread(signature, 1, 8, r.file) != 8 || png_sig_cmp(signature, 0, 8) != 0)
    fail("not a PNG file; export the height map as PNG, 16-bit grey, or name its 'format'");
  r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, on_error, on_warning);
  if (r.png) r.info = png_create_info_struct(r.png);
  if (!r.info) fail("libpng could not start");
  if (!read_header(r)) fail(r.problem);
  if (r.depth != 16 || r.colour != PNG_COLOR_TYPE_GRAY)
    fail("the PNG is " + std::to_string(r.depth) + "-bit " + colour_name(r.colour) +
         "; a height map needs 16-bit grey: export it so");
  if (r.width < 2 || r.height < 2) fail("a height map needs at least 2 x 2 pixels");

  HeightGrid g{static_cast<int>(r.width), static_cast<int>(r.height), 0, 0, spacing, spacing, {}};
  r.bytes.resize(std::size_t{2} * r.width * r.height);
  for (png_uint_32 j = 0; j < r.height; ++j) r.rows.push_back(r.bytes.data() + std::size_t{2} * r.width * j);
  if (!read_pixels(r)) fail(r.problem);

  // PNG is big-endian; its first row is the largest y.
  g.z.resize(std::size_t{1} * r.width * r.height);
  for (std::size_t j = 0; j < r.height; ++j)
    for (std::size_t i = 0; i < r.width; ++i) {
      const png_byte* p = r.rows[r.height - 1 - j] + 2 * i;
      g.z[j * r.width + i] = lowest + (highest - lowest) * (256.0 * p[0] + p[1]) / 65535.0;
    }
  return g;
}

}  // namespace grouser
