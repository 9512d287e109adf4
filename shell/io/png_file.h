#pragma once
// Reads grey images from PNG files.
#include <functional>
#include <string>

#include "shell/io/pgm_file.h"

namespace sunder::shell {

/// True where the file begins as a PNG file does.
bool is_png(const std::string& path);

/// Reads a grey image of 1, 2, 4, 8 or 16 bits, its numbers as they are: no gamma is applied. `accept` is as for
/// read_pgm(). Throws Error that says what is wrong with the file; the message does not name the file. Colours,
/// palettes and transparency are refused.
GreyImage read_png(const std::string& path, const std::function<void(double width, double height)>& accept);

}  // namespace sunder::shell
