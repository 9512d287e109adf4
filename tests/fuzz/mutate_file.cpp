// Mutations of files: bytes, and numbers, which most readers take as digits.
#include <algorithm>
#include <cctype>
#include <cstring>
#include <random>

#include "tests/fuzz/targets.h"

namespace sunder::fuzz {
namespace {

using FileRandom = std::minstd_rand;

std::string odd_digits(FileRandom& random) {
  constexpr const char* kOdd[] = {
      "0",      "-1",    "1",          "2",          "-0",  "3.5",  "1e308", "-1e308",
      "1e-320", "1e999", "4294967296", "2147483648", "nan", "-inf", "0x1p9", "99999999999999999999",
      "65536",  "",      "1e9",        "*",          "$",   "#1",   "#99"};
  return kOdd[random() % std::size(kOdd)];
}

// A run of digits, with what stands in it as in a number.
void change_number(std::string& s, FileRandom& random) {
  const auto is_digit = [&](std::size_t k) { return std::isdigit(static_cast<unsigned char>(s[k])) != 0; };
  std::size_t at = 1 + random() % (s.size() - 1);
  for (std::size_t k = 0; k < s.size() && !is_digit(at); ++k) at = at + 1 < s.size() ? at + 1 : 1;
  std::size_t end = at;
  while (end < s.size() && (is_digit(end) || s[end] == '.' || s[end] == 'e')) ++end;
  if (end > at) s.replace(at, end - at, odd_digits(random));
}

void change_word(std::string& s, FileRandom& random) {  // of four bytes
  constexpr std::uint32_t kOdd[] = {0,          1,          2,          0x7fffffff, 0x80000000,
                                    0xffffffff, 0x7f800000, 0x7fc00000, 0x4e4f534a, 100000};
  if (s.size() < 6) return;
  const std::uint32_t odd = kOdd[random() % std::size(kOdd)];
  std::memcpy(s.data() + 1 + random() % (s.size() - 5), &odd, 4);
}

}  // namespace

std::string mutate_file(const std::string& bytes, std::size_t most, unsigned seed) {
  FileRandom random(seed | 1u);
  std::string s = bytes;
  random.discard(3);
  for (unsigned n = 1 + random() % 3; n > 0 && s.size() > 2; --n) {
    const std::size_t a = 1 + random() % (s.size() - 1),
                      length = 1 + random() % std::min<std::size_t>(64, s.size() - a);
    const std::size_t b = 1 + random() % (s.size() - 1);
    switch (random() % 10) {
      case 0:
        s[a] = static_cast<char>(s[a] ^ 1 << random() % 8);
        break;
      case 1:
        s[a] = static_cast<char>(random() % 256);
        break;
      case 2:
        s.erase(a, length);
        break;
      case 3:
        s.insert(b, s.substr(a, length));
        break;
      case 4:
        if (random() % 8 == 0) s.resize(a);
        break;
      case 5:
        change_word(s, random);
        break;
      case 6: {
        const std::string moved = s.substr(a, length);
        s.erase(a, length), s.insert(std::min(b, s.size()), moved);
        break;
      }
      default:
        change_number(s, random);
    }
  }
  // The first byte, which says how the rest is read, now and then: most of its other values are other formats.
  if (!s.empty() && random() % 16 == 0) s[0] = static_cast<char>(random() % 256);
  if (s.size() > most) s.resize(most);
  return s;
}

}  // namespace sunder::fuzz
