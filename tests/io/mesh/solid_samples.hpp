// The same two tetrahedra in every supported format. Nodes are numbered 10, 20, 30, 40 and 70 where numbers
// may be sparse. Node 99 is unused, one triangle is no solid element, and the regions are 5 and 7.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/io/bytes.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor::test {

/// Mesh that every sample contains.
inline SolidMesh sample_mesh() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {0, 0, 1.5}}, 4, {0, 1, 3, 4, 1, 2, 3, 4}, {5, 7}};
}

inline std::string gmsh_1() {
  return "$NOD\n6\n10 0 0 0\n20 1 0 0\n99 9 9 9\n70 1 1 1\n30 0 1 0\n40 0 0 1.5\n$ENDNOD\n"
         "$ELM\n3\n1 2 1 1 3 10 20 30\n4 4 5 1 4 10 20 30 40\n8 4 7 1 4 20 70 30 40\n$ENDELM\n";
}

inline std::string gmsh_2() {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 5 \"liver\"\n$EndPhysicalNames\n"
         "$Nodes\n6\n10 0 0 0\n20 1 0 0\n99 9 9 9\n70 1 1 1\n30 0 1 0\n40 0 0 1.5\n$EndNodes\n"
         "$Elements\n3\n1 2 2 1 1 10 20 30\n4 4 2 5 1 10 20 30 40\n8 4 3 7 1 0 20 70 30 40\n$EndElements\n";
}

inline std::string gmsh_2_binary(bool is_big_endian) {
  Bytes out(is_big_endian);
  out.raw("$MeshFormat\n2.2 1 8\n").ints({1}).raw("\n$EndMeshFormat\n$Nodes\n6\n");
  out.ints({10}).reals({0, 0, 0}).ints({20}).reals({1, 0, 0}).ints({99}).reals({9, 9, 9});
  out.ints({70}).reals({1, 1, 1}).ints({30}).reals({0, 1, 0}).ints({40}).reals({0, 0, 1.5});
  out.raw("\n$EndNodes\n$Elements\n3\n").ints({2, 1, 2, 1, 1, 1, 10, 20, 30});
  out.ints({4, 2, 2, 4, 5, 1, 10, 20, 30, 40, 8, 7, 1, 20, 70, 30, 40});
  return out.raw("\n$EndElements\n").text;
}

inline std::string gmsh_4() {
  return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
         "$Entities\n1 0 1 2\n1 0 0 0 0\n3 0 0 0 1 1 0 1 12 0\n1 0 0 0 1 1 1 1 5 1 3\n2 0 0 0 1 1 1 1 7 1 3\n"
         "$EndEntities\n"
         "$Nodes\n2 6 10 99\n0 1 0 1\n10\n0 0 0\n3 2 1 5\n20\n99\n70\n30\n40\n"
         "1 0 0 .1 .2 .3\n9 9 9 0 0 0\n1 1 1 0 0 0\n0 1 0 0 0 0\n0 0 1.5 0 0 0\n$EndNodes\n"
         "$Elements\n3 3 1 8\n2 3 2 1\n1 10 20 30\n3 1 4 1\n4 10 20 30 40\n3 2 4 1\n8 20 70 30 40\n"
         "$EndElements\n";
}

inline std::string gmsh_4_binary(bool is_big_endian) {
  Bytes out(is_big_endian);
  out.raw("$MeshFormat\n4.1 1 8\n").ints({1}).raw("\n$EndMeshFormat\n$Entities\n").sizes({0, 0, 0, 2});
  for (const int volume : {1, 2})
    out.ints({volume}).reals({0, 0, 0, 1, 1, 1}).sizes({1}).ints({volume == 1 ? 5 : 7}).sizes({0});
  out.raw("\n$EndEntities\n$Nodes\n").sizes({1, 6, 10, 99}).ints({3, 1, 0}).sizes({6});
  out.sizes({10, 20, 99, 70, 30, 40});
  out.reals({0, 0, 0, 1, 0, 0, 9, 9, 9, 1, 1, 1, 0, 1, 0, 0, 0, 1.5});
  out.raw("\n$EndNodes\n$Elements\n").sizes({3, 3, 1, 8}).ints({2, 3, 2}).sizes({1, 1, 10, 20, 30});
  out.ints({3, 1, 4}).sizes({1, 4, 10, 20, 30, 40}).ints({3, 2, 4}).sizes({1, 8, 20, 70, 30, 40});
  return out.raw("\n$EndElements\n").text;
}

inline std::string vtk() {
  return "# vtk DataFile Version 3.0\ntwo tetrahedra\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n"
         "0 0 0 1 0 0\n9 9 9 1 1 1 0 1 0 0 0 1.5\nCELLS 3 14\n3 0 1 4\n4 0 1 4 5\n4 1 3 4 5\nCELL_TYPES "
         "3\n5\n"
         "10\n10\nPOINT_DATA 6\nSCALARS depth float\nLOOKUP_TABLE default\n0 1 2 3 4 5\n"
         "CELL_DATA 3\nVECTORS fiber double\n1 0 0 1 0 0 1 0 0\nSCALARS region int 1\n"
         "LOOKUP_TABLE default\n1 5 7\n";
}

inline std::string vtk_binary() {
  Bytes out(true);
  out.raw("# vtk DataFile Version 4.2\ntwo\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n");
  out.reals({0, 0, 0, 1, 0, 0, 9, 9, 9, 1, 1, 1, 0, 1, 0, 0, 0, 1.5});
  out.raw("\nCELLS 3 14\n").ints({3, 0, 1, 4, 4, 0, 1, 4, 5, 4, 1, 3, 4, 5}).raw("\nCELL_TYPES 3\n");
  out.ints({5, 10, 10}).raw("\nCELL_DATA 3\nFIELD FieldData 2\nquality 1 3 double\n").reals({1, .5, .5});
  out.raw("\nMETADATA\nINFORMATION 0\n\nregion 1 3 unsigned_char\n");
  return out.raw(std::string("\1\5\7", 3) + "\n").text;
}

inline std::string vtk_5_binary() {
  Bytes out(true);
  out.raw("# vtk DataFile Version 5.1\ntwo\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n");
  out.reals({0, 0, 0, 1, 0, 0, 9, 9, 9, 1, 1, 1, 0, 1, 0, 0, 0, 1.5});
  out.raw("\nMETADATA\nINFORMATION 0\n\nCELLS 4 11\nOFFSETS vtktypeint64\n").sizes({0, 3, 7, 11});
  out.raw("\nCONNECTIVITY vtktypeint64\n").sizes({0, 1, 4, 0, 1, 4, 5, 1, 3, 4, 5});
  out.raw("\nCELL_TYPES 3\n").ints({5, 10, 10}).raw("\nCELL_DATA 3\nSCALARS material short\n");
  out.raw("LOOKUP_TABLE default\n").add(std::int16_t(1)).add(std::int16_t(5)).add(std::int16_t(7));
  return out.raw("\n").text;
}

inline std::string vtu() {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"6\" NumberOfCells=\"3\">\n<Points>\n"
         "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n"
         "0 0 0 1 0 0 9 9 9\n1 1 1 0 1 0 0 0 1.5\n</DataArray>\n</Points>\n<Cells>\n"
         "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 4 0 1 4 5 1 3 4 "
         "5</DataArray>\n"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3 7 11</DataArray>\n"
         "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5 10 10</DataArray>\n</Cells>\n"
         "<CellData>\n<DataArray type=\"Int32\" Name=\"region\" format=\"ascii\">1 5 7</DataArray>\n"
         "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

inline std::string medit() {
  return "MeshVersionFormatted 2\n# made by hand\nDimension\n3\nVertices\n6\n0 0 0 0\n1 0 0 0\n9 9 9 0\n"
         "1 1 1 0\n0 1 0 0\n0 0 1.5 0\nTriangles\n1\n1 2 5 1\nTetrahedra\n2\n1 2 5 6 5\n2 4 5 6 7\nEnd\n";
}

inline std::string tetgen_node(int first) {
  std::string text = "# points\n6 3 1 1\n";
  const char* positions[] = {"0 0 0", "1 0 0", "9 9 9", "1 1 1", "0 1 0", "0 0 1.5"};
  for (int n = 0; n < 6; n++) text += std::to_string(n + first) + " " + positions[n] + " 0.5 1  # a point\n";
  return text;
}
inline std::string tetgen_ele(int first) {
  const auto line = [&](int tet, const std::vector<int>& nodes, int region) {
    std::string text = std::to_string(tet + first);
    for (const int n : nodes) text += " " + std::to_string(n + first);
    return text + " " + std::to_string(region) + "\n";
  };
  return "2 4 1\n" + line(0, {0, 1, 4, 5}, 5) + line(1, {1, 3, 4, 5}, 7) + "# the end";
}

}  // namespace turgor::test
