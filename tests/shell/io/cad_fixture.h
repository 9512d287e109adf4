#pragma once
// What tests of STEP and IGES files have in common: a folder, a scene, and writers of files.
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "coupler/scene/load.h"
#include "shell/io/build.h"
#include "shell/io/cad_file.h"

#ifdef SUNDER_CAD
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Version.hxx>
#include <StepData_StepModel.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Circ.hxx>
#endif

namespace sunder::shell {

/// A folder of this test's own, gone afterwards.
class Cad : public testing::Test {
 protected:
  Cad() { std::filesystem::create_directories(folder_); }
  ~Cad() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name) const { return folder_ + "/" + name; }

  /// The setup of a scene with one shell; `cad` is its face, `after` what stands behind the shell.
  RunSetup setup(const std::string& cad, const std::string& after = "") const {
    std::ofstream(file("scene.textproto")) << R"(name: "cad"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.0001
  cad { )" << cad << " }\n}\n" << after;
    return build(scene::load(file("scene.textproto"), {}));
  }
  Patch patch(const std::string& cad) const { return setup(cad).shells[0].model.patch; }
  /// The face as it is read, before trims move control points beside them.
  CadSurface surface(const std::string& cad) const {
    setup(cad);
    const scene::LoadedScene scene = scene::load(file("scene.textproto"), {});
    CadFiles files;
    return files.of(scene, "shells[0].cad", scene.message.shells(0).cad())
        .surfaces(scene, "shells[0].cad", scene.message.shells(0).cad())[0];
  }
  std::string refusal(const std::string& cad) const {
    try {
      patch(cad);
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.line, 9) << e.what();
      EXPECT_EQ(e.field.rfind("shells[0].cad", 0), 0u) << e.field;
      return e.what();
    }
    return "accepted";
  }

  /// The message of any refusal.
  std::string error(const std::string& cad) const {
    try {
      patch(cad);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }

  std::string folder_ = fmt::format("{}cad_test_{}", testing::TempDir(), getpid());
};

#define EXPECT_SAYS(text, part) EXPECT_PRED2(says, text, part)
inline bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

#ifdef SUNDER_CAD

constexpr double kRadius = 25.0, kLength = 40.0;  // [mm]

/// OpenCASCADE's writers speak too; the test's output is not theirs.
inline void hush() { Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream)); }

inline void write_step(const TopoDS_Shape& shape, const std::string& file, const char* unit = "MM") {
  hush();
  const STEPControl_Writer first;  // makes the table of settings
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;
#if OCC_VERSION_HEX >= 0x070800  // the setting names the unit, and the model scales
  writer.Model()->SetLocalLengthUnit(1.0);
  writer.Model()->SetWriteLengthUnit(unit == std::string("INCH") ? 25.4 : unit == std::string("M") ? 1000.0 : 1.0);
#endif
  ASSERT_EQ(writer.Transfer(shape, STEPControl_AsIs), IFSelect_RetDone);
  ASSERT_EQ(writer.Write(file.c_str()), IFSelect_RetDone);
  Interface_Static::SetCVal("write.step.unit", "MM");
}

inline void write_iges(const TopoDS_Shape& shape, const std::string& file, const char* unit = "MM", int as_brep = 0) {
  hush();
  IGESControl_Writer writer(unit, as_brep);
  ASSERT_TRUE(writer.AddShape(shape));
  writer.ComputeModel();
  ASSERT_TRUE(writer.Write(file.c_str()));
}

inline TopoDS_Face on(const Handle(Geom_Surface) & surface, double u0, double u1, double v0, double v1) {
  return BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, 1e-7).Face();
}
inline TopoDS_Face whole(const Handle(Geom_Surface) & surface) { return BRepBuilderAPI_MakeFace(surface, 1e-7).Face(); }

inline TopoDS_Face sector(double degrees, bool reversed = false) {
  const double half = 0.5 * degrees * M_PI / 180.0;
  TopoDS_Face face = on(new Geom_CylindricalSurface(gp_Ax3(), kRadius), -half, half, 0, kLength);
  if (reversed) face.Reverse();
  return face;
}

inline TopoDS_Wire circle(double radius) {
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(), radius)));
}

#endif

}  // namespace sunder::shell
