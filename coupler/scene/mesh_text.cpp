// Reads OFF and OBJ files, line by line.
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

class Lines {
 public:
  /// `continued`: a backslash at the end of a line joins the next one to it.
  Lines(MeshFile& mesh, bool continued) : mesh_(mesh), in_(mesh.file), continued_(continued) {}

  /// Goes to the next line that is neither empty nor a comment; false at the end. Comments behind `#` are cut off.
  bool next() {
    while (read()) {
      number_ += lines_, lines_ = 1;
      while (continued_ && !line_.empty() && line_.back() == '\\' && line_[line_.find_first_not_of(" \t")] != '#') {
        line_.back() = ' ';
        const std::string before = line_;
        if (!read()) line_.clear();
        line_ = before + line_, ++lines_;
      }
      line_ = line_.substr(0, line_.find('#'));
      if (line_.find_first_not_of(" \t") != std::string::npos) return true;
    }
    return false;
  }

  const std::string& text() const { return line_; }
  int number() const { return number_; }  // of the first one, where lines are joined
  std::string where() const { return fmt::format("line {}", number_); }

  void point(std::istringstream& words) {
    Vec3 p;
    if (!(words >> p.x() >> p.y() >> p.z())) fail("is no point of three numbers");
    mesh_.add(p, where());
  }
  /// A colour that follows a point.
  void colour(std::istringstream& words) {
    std::vector<double> rest;
    for (double x; words >> x;) rest.push_back(x);
    if (rest.size() == 3) mesh_.colour(Vec3(rest[0], rest[1], rest[2]));
  }
  /// `what` follows the text of the line.
  [[noreturn]] void fail(const std::string& what) const { mesh_.fail_at(where(), fmt::format("'{}' {}", line_, what)); }

 private:
  bool read() {
    if (!std::getline(in_, line_)) return false;
    while (!line_.empty() && (line_.back() == '\r' || line_.back() == ' ' || line_.back() == '\t')) line_.pop_back();
    return true;
  }

  MeshFile& mesh_;
  std::ifstream in_;
  const bool continued_;
  std::string line_;
  int number_ = 0, lines_ = 1;
};

// Header of an OFF file: the word OFF, with C or N before it where colours or normals follow the coordinates. Then the
// numbers of points, faces and edges, on the same line or the next.
struct Counts {
  std::size_t points = 0, faces = 0;
};

bool off_counts(Lines& in, bool with_faces, Counts& counts) {
  if (!in.next()) return false;
  std::string text = in.text();
  const std::size_t begin = text.find_first_not_of(" \t"), end = text.find("OFF", begin);
  if (end == std::string::npos || text.substr(begin, end - begin).find_first_not_of("STCN") != std::string::npos)
    return false;
  text = text.substr(end + 3);
  if (text.find_first_not_of(" \t") == std::string::npos) {
    if (!in.next()) return false;
    text = in.text();
  }
  std::istringstream words(text);
  return static_cast<bool>(words >> counts.points) && counts.points > 0 && counts.points <= kMostPoints &&
         (!with_faces || static_cast<bool>(words >> counts.faces));
}

}  // namespace

void read_off(MeshFile& mesh) {
  Lines in(mesh, false);
  Counts counts;
  if (!off_counts(in, mesh.with_faces, counts))
    mesh.fail(
        fmt::format("does not start as an OFF file does: the word OFF, then the numbers of points (at most {}), "
                    "faces and edges",
                    kMostPoints));
  while (mesh.points.size() < counts.points && in.next()) {
    std::istringstream words(in.text());
    in.point(words);
  }
  if (!mesh.with_faces) return;
  if (mesh.points.size() != counts.points)
    mesh.fail(fmt::format("ends after {} of its {} points", mesh.points.size(), counts.points));
  while (mesh.polygons.size() < counts.faces) {
    if (!in.next()) mesh.fail(fmt::format("ends after {} of its {} faces", mesh.polygons.size(), counts.faces));
    std::istringstream words(in.text());
    std::size_t count = 0;
    words >> count;
    Polygon polygon{{}, in.number()};
    for (int corner; polygon.corners.size() < count && words >> corner;) polygon.corners.push_back(corner);
    if (count < 3 || polygon.corners.size() != count)
      in.fail("is no face, which is the number of its corners and these");
    mesh.polygons.push_back(std::move(polygon));
  }
}

namespace {

// Groups, object and material of the faces that follow.
class Tags {
 public:
  explicit Tags(MeshFile& mesh) : mesh_(mesh) {}

  /// Takes in a line that says one of them.
  void read(const std::string& kind, std::istringstream& words) {
    if (kind != "g" && kind != "o" && kind != "usemtl") return;
    std::vector<std::string> names;
    for (std::string word; words >> word;) names.push_back(word);
    if (kind == "g")
      groups_ = names;
    else
      (kind == "o" ? object_ : usemtl_) = fmt::format("{}", fmt::join(names, " "));
    now_ = -2;
  }
  /// Index of what holds now; -1: nothing has been said.
  int now() {
    if (now_ != -2) return now_;
    FaceTag tag{groups_, usemtl_};
    if (!object_.empty()) tag.groups.push_back(object_);
    const auto [known, is_new] = number_.try_emplace({tag.groups, tag.usemtl}, static_cast<int>(mesh_.tags.size()));
    if (is_new) mesh_.tags.push_back(tag);
    return now_ = known->second;
  }

 private:
  MeshFile& mesh_;
  std::vector<std::string> groups_;
  std::string object_, usemtl_;
  std::map<std::pair<std::vector<std::string>, std::string>, int> number_;
  int now_ = -1;  // -2: not looked up
};

}  // namespace

namespace {

// Index of the texture coordinates of a corner "point/texture" or "point/texture/normal"; -1: it has none. Files
// without any may have indices all the same.
int texture_of(const MeshFile& mesh, const std::string& word, const std::string& where) {
  const std::size_t slash = word.find('/');
  if (mesh.texture.empty() || slash == std::string::npos || slash + 1 == word.size() || word[slash + 1] == '/')
    return -1;
  const long index = std::strtol(word.c_str() + slash + 1, nullptr, 10), known = static_cast<long>(mesh.texture.size());
  if (index == 0 || index < -known || index > known)
    mesh.fail_at(where, fmt::format("'{}' has texture coordinates {}, none of the {} vt before it, which count from 1; "
                                    "export the file again, or without texture coordinates",
                                    word, index, known));
  return static_cast<int>(index > 0 ? index - 1 : known + index);
}

}  // namespace

void read_obj(MeshFile& mesh) {
  Lines in(mesh, true);
  Tags tags(mesh);
  while (in.next()) {
    std::istringstream words(in.text());
    std::string kind;
    words >> kind;
    if (kind == "v") in.point(words), in.colour(words);
    if (kind == "vt" && mesh.with_texture) {
      Vec2 uv = Vec2::Zero();
      if (!(words >> uv.x()))
        in.fail(
            "is no texture coordinate of one to three numbers; export the file again, or without texture coordinates");
      words >> uv.y();  // 0 where it is left out
      mesh.texture.push_back(uv);
    }
    tags.read(kind, words);
    if (kind != "f" || !mesh.with_faces) continue;
    Polygon polygon{{}, in.number(), tags.now()};
    for (std::string word; words >> word;) {  // corner, or corner/texture/normal; negative: counted from the last point
      const long corner = std::strtol(word.c_str(), nullptr, 10), points = static_cast<long>(mesh.points.size());
      if (corner == 0 || corner < -points || corner > points)
        mesh.fail_at(in.where(),
                     fmt::format("'{}' is none of the {} points before it, which count from 1", word, points));
      polygon.corners.push_back(static_cast<int>(corner > 0 ? corner - 1 : points + corner));
      if (mesh.with_texture) polygon.texture.push_back(texture_of(mesh, word, in.where()));
    }
    mesh.polygons.push_back(std::move(polygon));
  }
}

}  // namespace sunder::scene
