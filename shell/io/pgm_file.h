#pragma once
// Grey images: PGM files, binary (P5) or plain (P2), of 8 or 16 bits.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sunder::shell {

struct GreyImage {
  int width = 0, height = 0, white = 255;
  std::vector<std::uint16_t> pixels;  // rows from the top, from the left; 0 to `white`

  /// 0 black to 1 white at a point, (0, 0) the lower left corner and (1, 1) the upper right one: linear between the
  /// middles of pixels, constant beyond the outer ones.
  double grey(double right, double up) const;
};

/// `accept` is asked about width and height before any pixel is read; it throws where they will not do. They are whole
/// numbers, whatever the file claims. Throws Error that says what is wrong with the file, without its name.
GreyImage read_pgm(const std::string& path, const std::function<void(double width, double height)>& accept);

}  // namespace sunder::shell
