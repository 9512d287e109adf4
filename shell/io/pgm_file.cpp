#include "shell/io/pgm_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr int kMostDigits = 18;  // digits of a number: enough to report any size

bool blank(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// Reads the next number of the head and skips comments.
double head_number(std::istream& in, const char* what) {
  int c = in.get();
  while (blank(c) || c == '#') {
    while (c == '#' && in.good() && in.peek() != '\n') in.get();
    c = in.get();
  }
  double number = 0.0;
  int digits = 0;
  for (; c >= '0' && c <= '9' && digits < kMostDigits; c = in.get(), ++digits) number = 10.0 * number + (c - '0');
  // One blank ends a number. After the last number the pixels follow at once.
  require(digits > 0 && blank(c), "its head has no {}; after P5 or P2 come width, height and the grey of white", what);
  return number;
}

}  // namespace

double GreyImage::grey(double right, double up) const {
  const double x = std::clamp(right * width - 0.5, 0.0, width - 1.0),
               y = std::clamp((1.0 - up) * height - 0.5, 0.0, height - 1.0);
  const int i = std::min(static_cast<int>(x), width - 2), j = std::min(static_cast<int>(y), height - 2);
  const auto at = [&](int i, int j) { return static_cast<double>(pixels[static_cast<std::size_t>(j) * width + i]); };
  const double a = x - i, b = y - j;
  return ((1.0 - b) * ((1.0 - a) * at(i, j) + a * at(i + 1, j)) +
          b * ((1.0 - a) * at(i, j + 1) + a * at(i + 1, j + 1))) /
         white;
}

GreyImage read_pgm(const std::string& path, const std::function<void(double, double)>& accept) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  const double bytes = static_cast<double>(in.tellg());
  in.seekg(0);
  char magic[2] = {};
  in.read(magic, 2);
  require(in.good() && magic[0] == 'P' && (magic[1] == '5' || magic[1] == '2'),
          "is neither a PNG nor a PGM file: it begins with neither of their signs; convert it, as in: convert map.jpg "
          "-colorspace Gray map.png");
  const bool plain = magic[1] == '2';
  const double width = head_number(in, "width"), height = head_number(in, "height"), white = head_number(in, "white");
  accept(width, height);
  require(white >= 1.0 && white <= 65535.0, "says that white is {}; 1 to 65535", white);
  GreyImage image;
  image.width = static_cast<int>(width), image.height = static_cast<int>(height), image.white = static_cast<int>(white);
  const double rest = bytes - static_cast<double>(in.tellg());
  const int each = plain ? 2 : white > 255.0 ? 2 : 1;  // least bytes per pixel; plain: a digit and a blank
  const double least = width * height * each - (plain ? 1.0 : 0.0);
  require(rest >= least, "ends too early: {} x {} pixels need {} bytes{}, and {} follow its head", width, height, least,
          plain ? " or more" : "", rest);
  const std::size_t count = static_cast<std::size_t>(width * height);
  image.pixels.resize(count);
  const auto check_grey = [&](std::size_t k, long value) {
    require(value <= image.white, "has a pixel of {} in row {}, column {}, whiter than white, which is {}", value,
            k / image.width, k % image.width, image.white);
  };
  if (plain) {
    for (std::size_t k = 0; k < count; ++k) {
      int c = in.get();
      while (blank(c)) c = in.get();
      long value = 0;
      require(c >= '0' && c <= '9', "has {} instead of the pixel of row {}, column {}",
              in.good() ? fmt::format("byte {}", c) : std::string("its end"), k / image.width, k % image.width);
      for (; c >= '0' && c <= '9' && value <= 65535; c = in.get()) value = 10 * value + (c - '0');
      check_grey(k, value);
      image.pixels[k] = static_cast<std::uint16_t>(value);
    }
  } else {
    std::vector<unsigned char> row(static_cast<std::size_t>(image.width) * each);
    for (std::size_t k = 0; k < count;) {
      in.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row.size()));
      require(in.good(), "cannot be read to its end");
      for (int i = 0; i < image.width; ++i, ++k) {
        const long value = each == 2 ? row[2 * i] << 8 | row[2 * i + 1] : row[i];
        check_grey(k, value);
        image.pixels[k] = static_cast<std::uint16_t>(value);
      }
    }
  }
  for (int c = in.get(); c != EOF; c = in.get())
    require(blank(c), "goes on after its {} x {} pixels; is the size in its head right?", width, height);
  return image;
}

}  // namespace sunder::shell
