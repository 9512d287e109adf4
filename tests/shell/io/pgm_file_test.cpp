// Grey images from PGM files: the numbers are as they were written, and what is no such file is refused.
#include "shell/io/pgm_file.h"

#include "tests/shell/io/own_file.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using Pixels = std::vector<std::uint16_t>;

const auto kAnyPgm = [](double, double) {};

GreyImage pgm_of(const std::string& content) {
  const OwnFile file("read.pgm", content);
  return read_pgm(file.path, kAnyPgm);
}

std::string pgm_refusal(const std::string& content) {
  try {
    pgm_of(content);
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST(PgmFile, NumbersAreThoseOfTheFileInEachForm) {
  const Pixels greys{0, 1, 32, 99, 200, 35};
  for (const std::string& content : {std::string("P2 3 2 200\n0 1 32\n99 200 35\n"),
                                     std::string("P2\n3 2\n200\n0 1\n32 99 200\n\n35"),  // any line breaks
                                     std::string("P5 3 2 200\n\x00\x01\x20\x63\xc8\x23", 17)}) {
    const GreyImage image = pgm_of(content);
    EXPECT_EQ(image.width, 3);
    EXPECT_EQ(image.height, 2);
    EXPECT_EQ(image.white, 200);
    EXPECT_EQ(image.pixels, greys);
  }
}

// From white = 256 on, a pixel has two bytes, the larger one first.
TEST(PgmFile, ABinaryPixelHasTwoBytesBeyond255) {
  EXPECT_EQ(pgm_of(std::string("P5 2 1 255\n\xff\x01", 13)).pixels, (Pixels{255, 1}));
  EXPECT_EQ(pgm_of(std::string("P5 2 1 256\n\x01\x00\x00\x01", 15)).pixels, (Pixels{256, 1}));
  const GreyImage most = pgm_of(std::string("P5 2 1 65535\n\xff\xff\x12\x34", 17));
  EXPECT_EQ(most.white, 65535);
  EXPECT_EQ(most.pixels, (Pixels{65535, 0x1234}));
  EXPECT_EQ(pgm_of("P2 2 1 65535\n65535 4660\n").pixels, most.pixels);
  EXPECT_EQ(pgm_of("P2 2 1 1\n0 1\n").pixels, (Pixels{0, 1}));
}

// One blank ends the head. A byte that looks like a blank or a comment is a pixel from there on.
TEST(PgmFile, CommentsBelongToTheHeadOnly) {
  EXPECT_EQ(pgm_of("P5# made by hand\n#\n 2 # width\n\t1\r\n# white is\n255\n# ").pixels, (Pixels{'#', ' '}));
  EXPECT_EQ(pgm_of("P5 2 1 255\n\n#").pixels, (Pixels{'\n', '#'}));
  EXPECT_EQ(pgm_of("P5 2 1 255\nab\n \r\n").pixels, (Pixels{'a', 'b'}));  // blanks may follow the pixels
  EXPECT_NE(pgm_refusal("P2 2 1 255\n1 # one\n 2\n").find("has byte 35 instead of the pixel of row 0, column 1"),
            std::string::npos);
}

TEST(PgmFile, GreyIsLinearBetweenCentresAndConstantBeyondThem) {
  const GreyImage image = pgm_of("P2 4 2 100\n0 40 80 100\n20 60 0 100\n");
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 4; ++column)  // centres of pixels; the first row is the upper one
      EXPECT_DOUBLE_EQ(image.grey((column + 0.5) / 4.0, 1.0 - (row + 0.5) / 2.0),
                       image.pixels[4 * row + column] / 100.0);
  EXPECT_DOUBLE_EQ(image.grey(0.25, 0.75), 0.2);  // half way from 0 to 40
  EXPECT_DOUBLE_EQ(image.grey(0.25, 0.5), 0.3);   // between 0, 40, 20 and 60
  EXPECT_DOUBLE_EQ(image.grey(0.0, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(image.grey(0.0, 0.0), 0.2);
  EXPECT_DOUBLE_EQ(image.grey(1.0, 0.1), 1.0);
  EXPECT_EQ(image.grey(-3.0, 7.0), image.grey(0.0, 1.0));
}

TEST(PgmFile, TheCallerSeesTheSizeBeforePixelsAreRead) {
  const OwnFile file("large.pgm", "P5 4503599627370496 12 255\n");
  double width = 0.0, height = 0.0;
  EXPECT_THROW(read_pgm(file.path,
                        [&](double w, double h) {
                          width = w, height = h;
                          throw Error(Exit::kBadInput, "test", "too large");
                        }),
               Error);
  EXPECT_EQ(width, 4503599627370496.0);
  EXPECT_EQ(height, 12.0);
  // A longer number is refused in the head: no caller sees a size that was cut off.
  file.write("P5 1234567890123456789 12 255\n");
  EXPECT_THROW(read_pgm(file.path, [](double, double) { ADD_FAILURE() << "a size of 19 digits"; }), Error);
}

TEST(PgmFile, GarbageIsRefused) {
  const auto refused = [](const std::string& content, const std::string& says) {
    EXPECT_NE(pgm_refusal(content).find(says), std::string::npos) << content << ": " << pgm_refusal(content);
  };
  refused("", "is neither a PNG nor a PGM file");
  refused("P", "is neither a PNG nor a PGM file");
  refused("\x89PNG\r\n", "convert map.jpg");
  refused("P6 2 2 255\n123412341234", "is neither a PNG nor a PGM file");
  refused("p5 2 2 255\n1234", "is neither a PNG nor a PGM file");
  refused("P5", "has no width; after P5 or P2 come width, height and the grey of white");
  refused("P5 2 x 255\n", "has no height");
  refused("P5 2 2", "has no height");  // no blank ends the number
  refused("P5 2 2 \n", "has no white; after P5 or P2");
  refused("P5 # 2 2 255 1234", "has no width");
  refused("P5 -2 2 255\n1234", "has no width");
  refused("P5 2.5 2 255\n1234", "has no width");
  refused("P5 2 2 0\n1234", "says that white is 0; 1 to 65535");
  refused("P5 2 2 65536\n12345678", "says that white is 65536");
  refused("P5 2 2 255\n12345", "goes on after its 2 x 2 pixels");
  refused("P2 2 2 255\n1 2 3 4 5\n", "goes on after its 2 x 2 pixels");
  refused("P5 16000 16000 65535\n12",
          "ends too early: 16000 x 16000 pixels need 512000000 bytes, and 2 follow its head");
  refused("P2 16000 16000 255\n12", "need 511999999 bytes or more, and 2 follow");
  refused("P5 2 2 60\n12zz", "has a pixel of 122 in row 1, column 0, whiter than white, which is 60");
  refused("P2 2 2 255\n1 2 3 256", "has a pixel of 256 in row 1, column 1");
  refused(std::string("P5 2 1 256\n\x00\x01\x01\x01", 15), "has a pixel of 257 in row 0, column 1");
  refused("P2 2 2 255\n1 2 3\n\n\n\n", "has its end instead of the pixel of row 1, column 1");
  refused("P2 2 2 255\n1 2 three 4", "has byte 116 instead of the pixel of row 1, column 0");
  refused("P2 2 2 255\n1 2 -3 4", "has byte 45");
  refused("P2 2 2 255\n1 2 99999999999999999999 4", "whiter than white");
}

TEST(PgmFile, IsRefusedWhereverItEnds) {
  for (const std::string& whole : {std::string("P5 2 2 255\nabcd"), std::string("P5 1 2 300\n\x01\x02\x00\x03", 15),
                                   std::string("P2 2 2 255\n1 2 3 4")}) {
    EXPECT_EQ(pgm_refusal(whole), "accepted");
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(pgm_refusal(whole.substr(0, size)), "accepted") << size << " of " << whole.size() << " bytes";
  }
}

TEST(PgmFile, ThatIsAbsentIsRefused) { EXPECT_THROW(read_pgm(small_scene::own_file("absent.pgm"), kAnyPgm), Error); }
