// VTK poly data files: every number comes back from the bytes, and a file that cannot be written is told.
#include "shell/io/vtp.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <limits>
#include <regex>
#include <sstream>

#include <sys/resource.h>

#include "tests/shell/io/own_file.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// The text of a file, and its raw bytes behind the underscore.
struct ReadVtp {
  std::string head, bytes;
  explicit ReadVtp(const std::string& content) {
    const std::string start = "<AppendedData encoding=\"raw\">\n_", end = "\n</AppendedData>\n</VTKFile>\n";
    const std::size_t at = content.find(start);
    EXPECT_NE(at, std::string::npos);
    EXPECT_GE(content.size(), end.size());
    EXPECT_EQ(content.substr(content.size() - end.size()), end);
    head = content.substr(0, at);
    bytes = content.substr(at + start.size(), content.size() - end.size() - at - start.size());
  }
  bool says(const std::string& part) const { return head.find(part) != std::string::npos; }

  // The head of the array `name` behind the first `after`, and the numbers that its offset points to.
  std::string element(const std::string& name, const std::string& after = "<PolyData>") const {
    const std::size_t from = head.find("Name=\"" + name + "\"", head.find(after));
    EXPECT_NE(from, std::string::npos) << name;
    if (from == std::string::npos) return "";
    const std::size_t begin = head.rfind('<', from);
    return head.substr(begin, head.find('>', from) - begin + 1);
  }
  template <class T>
  std::vector<T> numbers(const std::string& name, const std::string& after = "<PolyData>") const {
    std::smatch found;
    const std::string text = element(name, after);
    EXPECT_TRUE(std::regex_search(text, found, std::regex("offset=\"([0-9]+)\""))) << text;
    if (found.empty()) return {};
    return at<T>(std::stoull(found[1]));
  }
  template <class T>
  std::vector<T> at(std::size_t offset) const {
    std::uint64_t size = 0;
    EXPECT_LE(offset + sizeof size, bytes.size());
    std::memcpy(&size, bytes.data() + offset, sizeof size);
    EXPECT_LE(offset + sizeof size + size, bytes.size());
    std::vector<T> out(size / sizeof(T));
    std::memcpy(out.data(), bytes.data() + offset + sizeof size, size);
    return out;
  }
  // Number of arrays that follow one another without a gap, from the first byte to the last.
  int arrays() const {
    std::size_t offset = 0;
    int count = 0;
    for (std::uint64_t size = 0; offset + sizeof size <= bytes.size(); offset += sizeof size + size, ++count)
      std::memcpy(&size, bytes.data() + offset, sizeof size);
    EXPECT_EQ(offset, bytes.size());
    return count;
  }
};

ReadVtp written_vtp(const VtpMesh& mesh) {
  const OwnFile file("mesh.vtp", "");
  write_vtp(file.path, mesh);
  EXPECT_FALSE(std::filesystem::exists(file.path + ".part"));
  return ReadVtp(file.content());
}

using Integers = std::vector<std::int64_t>;

}  // namespace

TEST(Vtp, NumbersComeBackToTheBit) {
  const double tiny = std::numeric_limits<double>::denorm_min(), most = std::numeric_limits<double>::max(),
               none = std::numeric_limits<double>::quiet_NaN();
  VtpMesh mesh;
  mesh.points = {{0.1, -0.2, 1.0 / 3.0}, {tiny, most, -0.0}, {4, 5, 6}, {7, 8, 9}};
  mesh.polygons = {{0, 1, 2}, {3, 2, 1, 0}};
  mesh.point_data = {{"displacement", 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0.1}, false, "m", {"X", "Y", "Z"}}};
  mesh.cell_data = {{"energy", 1, {none, -most}}, {"id", 1, {-1, 9007199254740992.0}, true}};
  const ReadVtp read = written_vtp(mesh);
  EXPECT_TRUE(read.says("type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""));
  EXPECT_TRUE(
      read.says("NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
                "NumberOfPolys=\"2\""));
  const std::vector<double> points = read.numbers<double>("Points");
  ASSERT_EQ(points.size(), 12u);
  for (std::size_t k = 0; k < points.size(); ++k) EXPECT_EQ(points[k], mesh.points[k / 3][k % 3]);
  EXPECT_TRUE(std::signbit(points[5]));
  EXPECT_EQ(read.numbers<double>("displacement", "<PointData>"), mesh.point_data[0].values);
  const std::vector<double> energy = read.numbers<double>("energy", "<CellData>");
  ASSERT_EQ(energy.size(), 2u);
  EXPECT_TRUE(std::isnan(energy[0]));
  EXPECT_EQ(energy[1], -most);
  EXPECT_EQ(read.numbers<std::int64_t>("id", "<CellData>"), (Integers{-1, 9007199254740992}));
  EXPECT_EQ(read.numbers<std::int64_t>("connectivity", "<Polys>"), (Integers{0, 1, 2, 3, 2, 1, 0}));
  EXPECT_EQ(read.numbers<std::int64_t>("offsets", "<Polys>"), (Integers{3, 7}));
  EXPECT_EQ(read.arrays(), 8);  // three of data, points, and two each of lines and polygons
}

TEST(Vtp, AnArrayHasItsTypeComponentsAndUnit) {
  VtpMesh mesh;
  mesh.points = {{0, 0, 0}};
  mesh.verts = {0};
  mesh.point_data = {{"velocity", 3, {1, 2, 3}, false, "m/s", {"X", "Y", "Z"}}, {"damage", 1, {0.5}}};
  mesh.cell_data = {{"shell", 1, {2}, true}};
  const ReadVtp read = written_vtp(mesh);
  const std::string velocity = read.element("velocity");
  EXPECT_EQ(
      velocity.rfind("<DataArray type=\"Float64\" Name=\"velocity\" NumberOfComponents=\"3\" ComponentName0=\"X\" "
                     "ComponentName1=\"Y\" ComponentName2=\"Z\" format=\"appended\" offset=\"",
                     0),
      0u)
      << velocity;
  EXPECT_TRUE(read.says(velocity + "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">m/s</InformationKey>"
                                   "</DataArray>\n"));
  for (const auto& [name, type] : {std::pair{"damage", "Float64"}, {"shell", "Int64"}}) {
    const std::string plain = read.element(name);  // without a unit, the element ends itself
    EXPECT_EQ(
        plain.rfind(fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"1\" format", type, name), 0),
        0u)
        << plain;
    EXPECT_EQ(plain.substr(plain.size() - 2), "/>");
  }
}

// Cell data count points first, then lines, then polygons.
TEST(Vtp, CellsAreInTheOrderOfVtk) {
  VtpMesh mesh;
  for (int k = 0; k < 5; ++k) mesh.points.push_back(Vec3::Constant(k));
  mesh.verts = {4, 0};
  mesh.lines = {{0, 1, 2}, {3, 4}};
  mesh.polygons = {{0, 1, 2}};
  const ReadVtp read = written_vtp(mesh);
  EXPECT_TRUE(read.says("NumberOfVerts=\"2\" NumberOfLines=\"2\" NumberOfStrips=\"0\" NumberOfPolys=\"1\""));
  EXPECT_LT(read.head.find("<Verts>"), read.head.find("<Lines>"));
  EXPECT_LT(read.head.find("<Lines>"), read.head.find("<Polys>"));
  EXPECT_EQ(read.numbers<std::int64_t>("connectivity", "<Verts>"), (Integers{4, 0}));
  EXPECT_EQ(read.numbers<std::int64_t>("offsets", "<Verts>"), (Integers{1, 2}));
  EXPECT_EQ(read.numbers<std::int64_t>("connectivity", "<Lines>"), (Integers{0, 1, 2, 3, 4}));
  EXPECT_EQ(read.numbers<std::int64_t>("offsets", "<Lines>"), (Integers{3, 5}));
  EXPECT_EQ(read.numbers<std::int64_t>("offsets", "<Polys>"), Integers{3});
}

TEST(Vtp, OfNothingIsAWholeFile) {
  const ReadVtp read = written_vtp({});
  EXPECT_TRUE(
      read.says("NumberOfPoints=\"0\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
                "NumberOfPolys=\"0\""));
  EXPECT_FALSE(read.says("<Verts>"));
  EXPECT_FALSE(read.says("shell_name"));
  EXPECT_FALSE(read.says("shell_area_m2"));
  EXPECT_TRUE(read.numbers<double>("Points").empty());
  for (const char* cells : {"<Lines>", "<Polys>"}) {
    EXPECT_TRUE(read.numbers<std::int64_t>("connectivity", cells).empty());
    EXPECT_TRUE(read.numbers<std::int64_t>("offsets", cells).empty());
  }
  EXPECT_EQ(read.arrays(), 5);
}

TEST(Vtp, FieldDataHaveTheTimeNamesAndAreasOfShells) {
  VtpMesh mesh;
  mesh.time = 0.1 + 0.2;  // not 0.3
  mesh.shell_names = {"pane", "", "b\xc3\xa4"};
  mesh.shell_areas = {0.25, 1.0 / 3.0, 0.0};
  const ReadVtp read = written_vtp(mesh);
  std::smatch found;
  EXPECT_TRUE(std::regex_search(read.head, found, std::regex("Name=\"TimeValue\"[^>]*>([^<]*)</DataArray>")));
  EXPECT_EQ(std::stod(found[1]), mesh.time);
  EXPECT_TRUE(
      read.says("<Array type=\"String\" Name=\"shell_name\" NumberOfTuples=\"3\" format=\"ascii\">\n"
                "112 97 110 101 0\n0\n98 195 164 0\n</Array>\n"));
  EXPECT_TRUE(std::regex_search(
      read.head, found,
      std::regex("Name=\"shell_area_m2\" NumberOfTuples=\"3\" format=\"ascii\">([^<]*)</DataArray>")));
  std::istringstream areas(found[1]);
  for (const double area : mesh.shell_areas) {
    double value = -1.0;
    areas >> value;
    EXPECT_EQ(value, area);
  }
}

TEST(WriteAtomically, ReplacesAFileAndLeavesNoPart) {
  const OwnFile file("atomic.txt", "a long old text");
  const std::string text("new\0text\r\n", 10);
  write_atomically(file.path, text);
  EXPECT_EQ(file.content(), text);
  EXPECT_FALSE(std::filesystem::exists(file.path + ".part"));
  write_atomically(file.path, "");
  EXPECT_EQ(file.content(), "");
}

TEST(WriteAtomically, TellsTheFileThatCannotBeWritten) {
  const std::string inside = small_scene::own_file("absent_folder/a.txt");
  try {
    write_atomically(inside, "text");
    ADD_FAILURE() << inside;
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.kind, "bad_output");
    EXPECT_EQ(e.what(), inside + ": cannot be written; is there room and permission?");
  }
  EXPECT_THROW(write_vtp(inside, {}), Error);
  const std::string folder = small_scene::own_file("folder.vtp");
  std::filesystem::create_directories(folder + "/in");
  try {
    write_atomically(folder, "text");
    ADD_FAILURE() << folder;
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_output");
    EXPECT_EQ(e.what(), folder + ": cannot be replaced; is it a folder?");
  }
  EXPECT_TRUE(std::filesystem::exists(folder + "/in"));
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(std::filesystem::exists(folder + ".part"));
}

/// No file of this process grows beyond so many bytes while it lives: writing fails as on a full disk.
class LeastSpace {
 public:
  explicit LeastSpace(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit less{bytes, before_.rlim_max};
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &less);
  }
  ~LeastSpace() { setrlimit(RLIMIT_FSIZE, &before_), std::signal(SIGXFSZ, handler_); }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

// A full disk: the old file stays, and no part of the new one.
TEST(WriteAtomically, KeepsTheOldFileWhereTheNewOneDoesNotFit) {
  const OwnFile file("kept.txt", "old");
  const std::string part = file.path + ".part";
  {
    const LeastSpace space(1 << 10);
    EXPECT_THROW(write_atomically(file.path, std::string(1 << 20, 'x')), Error);
  }
  EXPECT_EQ(file.content(), "old");
  EXPECT_FALSE(std::filesystem::exists(part));
}
