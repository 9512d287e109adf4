// Grey images from PNG files: the numbers are as they were written, and what is no grey image is refused.
#include <png.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/io/png_file.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr int kWidth = 5, kHeight = 3;

int value(int row, int column, int bits) { return (37 * row + 11 * column + 1) % (1 << bits); }

// Writes an image of `kind` with `bits` a channel, all channels alike, and returns its path.
std::string written(const TemporaryFolder& folder, int kind, int bits, int interlace = PNG_INTERLACE_NONE,
                    bool transparent = false) {
  const std::string path = folder.path + "/map.png";
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, kWidth, kHeight, bits, kind, interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  const png_color palette[4] = {{0, 0, 0}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  if (kind == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 4);
  png_color_16 clear{};
  if (transparent) png_set_tRNS(png, info, nullptr, 0, &clear);
  png_set_gAMA(png, info, 0.45455);
  png_write_info(png, info);
  if (bits < 8) png_set_packing(png);  // a byte for each pixel here
  const int channels = png_get_channels(png, info), bytes = bits == 16 ? 2 : 1;
  std::vector<std::vector<unsigned char>> rows(kHeight);
  std::vector<png_bytep> starts;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column)
      for (int c = 0; c < channels; ++c) {
        const int v = kind == PNG_COLOR_TYPE_PALETTE ? value(row, column, 2) : value(row, column, bits);
        if (bytes == 2) rows[row].push_back(static_cast<unsigned char>(v >> 8));
        rows[row].push_back(static_cast<unsigned char>(v & 255));
      }
    starts.push_back(rows[row].data());
  }
  png_write_image(png, starts.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
  return path;
}

const auto kAny = [](double, double) {};

std::string png_refusal(const std::string& path) {
  try {
    read_png(path, kAny);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST(PngFile, NumbersAreAsTheyWereWritten) {
  const TemporaryFolder folder;
  for (const int bits : {1, 2, 4, 8, 16})
    for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
      const std::string path = written(folder, PNG_COLOR_TYPE_GRAY, bits, interlace);
      EXPECT_TRUE(is_png(path));
      const GreyImage image = read_png(path, kAny);
      ASSERT_EQ(image.width, kWidth);
      ASSERT_EQ(image.height, kHeight);
      EXPECT_EQ(image.white, (1 << bits) - 1);
      for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < kWidth; ++column)
          EXPECT_EQ(image.pixels[row * kWidth + column], value(row, column, bits))
              << bits << " bits, " << row << ", " << column;
    }
}

TEST(PngFile, WhatIsNoGreyImageIsRefusedWithARemedy) {
  const TemporaryFolder folder;
  EXPECT_NE(png_refusal(written(folder, PNG_COLOR_TYPE_PALETTE, 8)).find("has a palette"), std::string::npos);
  EXPECT_NE(png_refusal(written(folder, PNG_COLOR_TYPE_RGB, 8)).find("has colours"), std::string::npos);
  const std::string clear = png_refusal(written(folder, PNG_COLOR_TYPE_GRAY_ALPHA, 8));
  EXPECT_NE(clear.find("is transparent"), std::string::npos);
  EXPECT_NE(clear.find("save it as grey"), std::string::npos);
  EXPECT_NE(png_refusal(written(folder, PNG_COLOR_TYPE_GRAY, 8, PNG_INTERLACE_NONE, true)).find("is transparent"),
            std::string::npos);
  EXPECT_NE(png_refusal(folder.path + "/absent.png").find("cannot be opened"), std::string::npos);
}

TEST(PngFile, ADamagedFileIsRefusedWhereverItEnds) {
  const TemporaryFolder folder;
  const std::string path = written(folder, PNG_COLOR_TYPE_GRAY, 8);
  std::ifstream in(path, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  for (std::size_t size = 8; size + 12 < whole.size(); ++size) {  // without its end alone the pixels are there
    std::ofstream(path, std::ios::binary | std::ios::trunc) << whole.substr(0, size);
    EXPECT_TRUE(is_png(path));
    EXPECT_NE(png_refusal(path).find("is damaged"), std::string::npos) << size << " of " << whole.size() << " bytes";
  }
  std::ofstream(path, std::ios::binary | std::ios::trunc) << whole.substr(0, 7);
  EXPECT_FALSE(is_png(path));
}

TEST(PngFile, TheCallerBoundsTheSizeBeforePixelsAreRead) {
  const TemporaryFolder folder;
  const std::string path = written(folder, PNG_COLOR_TYPE_GRAY, 8);
  double width = 0.0, height = 0.0;
  EXPECT_THROW(read_png(path,
                        [&](double w, double h) {
                          width = w, height = h;
                          throw Error(Exit::kBadInput, "test", "too large");
                        }),
               Error);
  EXPECT_EQ(width, kWidth);
  EXPECT_EQ(height, kHeight);
}
