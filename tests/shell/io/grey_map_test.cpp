// Grey images beside a scene: which shapes fit the domain, and what a message suggests where none does.
#include "shell/io/grey_map.h"

#include <png.h>

#include "tests/shell/io/own_file.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A PNG file of one channel or several, its numbers row by row. `kind` is libpng's; a palette has two colours.
std::string png_bytes(int width, int height, int bits, int kind, const std::vector<int>& numbers) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  std::string out;
  const auto add = [](png_structp p, png_bytep data, std::size_t count) {
    static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), count);
  };
  png_set_write_fn(png, &out, add, nullptr);
  png_set_IHDR(png, info, width, height, bits, kind, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  const png_color colours[2] = {{0, 0, 0}, {255, 0, 0}};
  if (kind == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, colours, 2);
  png_write_info(png, info);
  if (bits < 8) png_set_packing(png);
  const std::size_t each = numbers.size() / height;
  for (int row = 0; row < height; ++row) {
    std::vector<unsigned char> line;
    for (std::size_t k = row * each; k < (row + 1) * each; ++k) {
      if (bits == 16) line.push_back(static_cast<unsigned char>(numbers[k] >> 8));
      line.push_back(static_cast<unsigned char>(numbers[k] & 255));
    }
    png_write_row(png, line.data());
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

// A plain image of white pixels.
std::string white_map(int width, int height) {
  std::string out = fmt::format("P2 {} {} 1\n", width, height);
  for (int k = 0; k < width * height; ++k) out += "1 ";
  return out;
}

GreyImage map_beside(const OwnFile& file, const std::optional<Vec2>& size) {
  scene::LoadedScene scene;
  scene.path = small_scene::own_file("grey_scene.textproto");
  return read_grey_map(scene, file.name, size, "shells[0].map");
}

std::string map_refusal(const std::string& content, const std::optional<Vec2>& size) {
  const OwnFile file("grey.pgm", content);
  try {
    map_beside(file, size);
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.field, "shells[0].map.path");
    EXPECT_NE(std::string(e.what()).find("'" + file.name + "' "), std::string::npos) << e.what();
    return e.what();
  }
  return "accepted";
}

void expect_map_refused(const std::string& content, const std::optional<Vec2>& size, const std::string& says) {
  const std::string told = map_refusal(content, size);
  EXPECT_NE(told.find(says), std::string::npos) << told;
}

}  // namespace

TEST(GreyMap, MayDifferFromTheShapeOfTheDomainByTwoPerCent) {
  const Vec2 square(0.5, 0.5);
  for (const auto& [width, height] : {std::pair{100, 100}, {101, 100}, {50, 51}, {2, 2}})
    EXPECT_EQ(map_refusal(white_map(width, height), square), "accepted") << width << " x " << height;
  expect_map_refused(white_map(103, 100), square,
                     "has 103 x 100 pixels, but the parameter domain is 0.5 m x 0.5 m, and the shapes may differ by "
                     "2 %: 103 x 103 or 100 x 100 would do");
  expect_map_refused(white_map(100, 103), square, "100 x 100 or 103 x 103 would do");
  EXPECT_EQ(map_refusal(white_map(60, 20), Vec2(0.3, 0.1)), "accepted");
  expect_map_refused(white_map(20, 60), Vec2(0.3, 0.1), "2 %: 180 x 60 would do");
}

TEST(GreyMap, WithoutADomainHasAnyShape) {
  for (const auto& [width, height] : {std::pair{2, 3000}, {77, 2}}) {
    const OwnFile file("any.pgm", white_map(width, height));
    const GreyImage image = map_beside(file, {});
    EXPECT_EQ(image.width, width);
    EXPECT_EQ(image.height, height);
  }
  expect_map_refused(white_map(1, 2), {}, "has 1 x 2 pixels, and an image has 2 to 16384 a side");
}

TEST(GreyMap, HasTwoTo16384PixelsASide) {
  expect_map_refused(white_map(1, 1), Vec2(1, 1), "has 1 x 1 pixels, and an image has 2 to 16384 a side: 1024 x 1024");
  expect_map_refused("P5 16385 2 255\n", {}, "has 16385 x 2 pixels, and an image has 2 to 16384 a side");
  expect_map_refused("P5 0 0 255\n", Vec2(1, 1), "has 0 x 0 pixels");
  expect_map_refused("P5 99999999999999 3 255\n", Vec2(1, 1), "has 99999999999999 x 3 pixels");
  // The largest size comes as far as its pixels.
  expect_map_refused("P5 16384 16384 255\n", Vec2(1, 1), "ends too early");
  const OwnFile longest("longest.pgm", white_map(16384, 2));
  EXPECT_EQ(map_beside(longest, Vec2(16.384, 0.002)).pixels.size(), 2u * 16384u);
}

TEST(GreyMap, OfADomainThatNoImageFitsIsRefused) {
  // 2 x 16384 pixels are the longest image: 8192 to 1, and 2 % more
  expect_map_refused(white_map(16, 2), Vec2(9.0, 1e-3), "no image has that shape; leave the image out");
  expect_map_refused(white_map(16, 2), Vec2(1e-3, 9.0), "no image has that shape; leave the image out");
  expect_map_refused(white_map(16, 2), Vec2(8.192, 1e-3), "16384 x 2 would do");
}

TEST(GreyMap, OfAPngHasTheGreysOfThePgmWhateverItsName) {
  for (const int bits : {1, 4, 8, 16}) {
    const int white = (1 << bits) - 1;
    const std::vector<int> greys{0, white / 2, white, white / 3};
    for (const char* name : {"grey.png", "grey.pgm"}) {
      const OwnFile png(name, png_bytes(2, 2, bits, PNG_COLOR_TYPE_GRAY, greys));
      const GreyImage a = map_beside(png, Vec2(0.2, 0.2));
      const OwnFile pgm("plain.pgm",
                        fmt::format("P2 2 2 {}\n{} {} {} {}\n", white, greys[0], greys[1], greys[2], greys[3]));
      const GreyImage b = map_beside(pgm, Vec2(0.2, 0.2));
      EXPECT_EQ(a.white, white);
      EXPECT_EQ(a.white, b.white);
      EXPECT_EQ(a.pixels, b.pixels) << name << ", " << bits << " bits";
    }
  }
}

TEST(GreyMap, OfAPngThatIsNotGreyOrDamagedIsRefused) {
  const auto refused = [](const std::string& content, const std::string& says) {
    expect_map_refused(content, Vec2(0.5, 0.5), says);
  };
  const auto of_kind = [](int kind, int channels) {
    return png_bytes(2, 2, 8, kind, std::vector<int>(4 * channels, 1));
  };
  refused(of_kind(PNG_COLOR_TYPE_PALETTE, 1), "has a palette, whose numbers are no greys");
  refused(of_kind(PNG_COLOR_TYPE_RGB, 3), "has colours");
  refused(of_kind(PNG_COLOR_TYPE_RGB_ALPHA, 4), "has colours");
  refused(of_kind(PNG_COLOR_TYPE_GRAY_ALPHA, 2), "is transparent in places");
  refused(png_bytes(4, 2, 8, PNG_COLOR_TYPE_GRAY, std::vector<int>(8, 7)), "has 4 x 2 pixels");
  const std::string good = png_bytes(2, 2, 8, PNG_COLOR_TYPE_GRAY, {1, 2, 3, 4});
  EXPECT_EQ(map_refusal(good, Vec2(0.5, 0.5)), "accepted");
  refused(good.substr(0, 20), "is damaged in its head");
  refused(good.substr(0, good.size() - 14), "is damaged: ");
  std::string changed = good;
  changed[changed.size() - 20] ^= 0x10;
  refused(changed, "is damaged: ");
}

TEST(GreyMap, ThatIsAbsentOrElsewhereIsRefused) {
  scene::LoadedScene scene;
  scene.path = small_scene::own_file("grey_scene.textproto");
  for (const auto& [name, says] : {std::pair{"none.pgm", "'none.pgm' cannot be read; is the name right?"},
                                   {"../x.pgm", "'../x.pgm' lies outside the scene's folder"},
                                   {".", "'.' cannot be read"},
                                   {"", "'' cannot be read"}}) {
    try {
      read_grey_map(scene, name, {}, "shells[2].strength_map");
      ADD_FAILURE() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.field, "shells[2].strength_map.path");
      EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
    }
  }
}

TEST(GreyMap, OfAWrongShapeIsRefusedWithTheLineOfTheScene) {
  const auto refused = [](const std::string& head, const std::vector<std::string>& says,
                          const std::vector<std::string>& settings) {
    const OwnFile map("shape.pgm", head);
    const std::string field = fmt::format("strength_map {{ path: \"{}\" low_factor: 0.5 }}", map.name);
    small_scene::expect_refusal(small_scene::with_fields(field, small_scene::kStrong), "shells[0].strength_map.path",
                                says, settings);
  };
  refused("P5 20000 20000 255\n", {":10:", "has 20000 x 20000 pixels", "1024 x 1024 would do"}, {});
  refused("P5 100 80 255\n", {"has 100 x 80 pixels", "0.5 m x 0.5 m", "100 x 100 or 80 x 80 would do"}, {});
  refused("P5 100 100 255\n", {"0.5 m x 0.25 m", "100 x 50 or 200 x 100 would do"},
          {"shells[pane].plate.size_y_m=0.25"});
}
