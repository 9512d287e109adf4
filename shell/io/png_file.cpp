#include "shell/io/png_file.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

// libpng reports errors by a function that must not return. It keeps the text here and jumps back.
struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  char what[200] = "";
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void keep(png_structp png, png_const_charp what) {
  auto* reader = static_cast<Reader*>(png_get_error_ptr(png));
  std::strncpy(reader->what, what, sizeof reader->what - 1);
  std::longjmp(png_jmpbuf(png), 1);
}

void ignore(png_structp, png_const_charp) {}

// Both functions return false where libpng fails. They hold nothing that a jump out of them would leave behind.
bool read_head(Reader& r, std::FILE* file) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_init_io(r.png, file);
  png_set_user_limits(r.png, 0x7fffffff, 0x7fffffff);  // `accept` bounds the size
  png_read_info(r.png, r.info);
  return true;
}

bool read_pixels(Reader& r, png_bytep* rows) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_read_image(r.png, rows);
  png_read_end(r.png, nullptr);
  return true;
}

void check_kind(const Reader& r) {
  const int kind = png_get_color_type(r.png, r.info);
  const char* remedy = "; save it as grey, as in: convert map.png -colorspace Gray -alpha off -depth 16 grey.png";
  require(kind != PNG_COLOR_TYPE_PALETTE, "has a palette, whose numbers are no greys{}", remedy);
  require((kind & PNG_COLOR_MASK_COLOR) == 0, "has colours, and a strength map is grey{}", remedy);
  require((kind & PNG_COLOR_MASK_ALPHA) == 0 && !png_get_valid(r.png, r.info, PNG_INFO_tRNS),
          "is transparent in places, where it says nothing{}", remedy);
}

}  // namespace

bool is_png(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  unsigned char begin[8] = {};
  return file && std::fread(begin, 1, sizeof begin, file.get()) == sizeof begin &&
         png_sig_cmp(begin, 0, sizeof begin) == 0;
}

GreyImage read_png(const std::string& path, const std::function<void(double, double)>& accept) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  require(file != nullptr, "cannot be opened");
  Reader r;
  r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, keep, ignore);
  r.info = r.png ? png_create_info_struct(r.png) : nullptr;
  ensure(r.info != nullptr, "libpng has no memory");
  require(read_head(r, file.get()), "is damaged in its head: {}", r.what);
  const double width = png_get_image_width(r.png, r.info), height = png_get_image_height(r.png, r.info);
  accept(width, height);
  check_kind(r);
  const int bits = png_get_bit_depth(r.png, r.info);
  GreyImage image;
  image.width = static_cast<int>(width), image.height = static_cast<int>(height), image.white = (1 << bits) - 1;
  if (bits < 8) png_set_packing(r.png);  // a byte for each pixel, the numbers as they are
  png_set_interlace_handling(r.png);
  png_read_update_info(r.png, r.info);
  const std::size_t bytes = png_get_rowbytes(r.png, r.info);
  std::vector<unsigned char> data(bytes * image.height);
  std::vector<png_bytep> rows;
  for (int k = 0; k < image.height; ++k) rows.push_back(data.data() + bytes * k);
  require(read_pixels(r, rows.data()), "is damaged: {}", r.what);
  image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
  for (int row = 0; row < image.height; ++row)
    for (int k = 0; k < image.width; ++k) {
      const unsigned char* at = rows[row] + (bits == 16 ? 2 * k : k);
      image.pixels[static_cast<std::size_t>(row) * image.width + k] =
          static_cast<std::uint16_t>(bits == 16 ? at[0] << 8 | at[1] : at[0]);
    }
  return image;
}

}  // namespace sunder::shell
