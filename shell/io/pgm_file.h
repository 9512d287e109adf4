#pragma once
// Reads grey images: PGM files, binary (P5) or plain (P2), with 8 or 16 bits.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sunder::shell {

/// An image of grey values.
struct GreyImage {
  int width = 0, height = 0, white = 255;
  std::vector<std::uint16_t> pixels;  // rows from the top, each from the left; 0 to `white`

  /// Returns the grey value at a point, 0 black to 1 white. (0, 0) is the lower left corner, (1, 1) the upper right
  /// one. Values are linear between pixel centres and constant beyond the outermost.
  double grey(double right, double up) const;
};

/// Reads an image. `accept` receives width and height, whole numbers, before any pixel is read; it may throw. Throws
/// Error that says what is wrong with the file; the message does not name the file.
GreyImage read_pgm(const std::string& path, const std::function<void(double width, double height)>& accept);

}  // namespace sunder::shell
