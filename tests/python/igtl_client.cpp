// A program of the OpenIGTLink library that connects to turgor.openigtlink: igtl_client PORT BODY TOOL
// TRACKED x y z [mm] Prints the first and the last point, and the counts, of the newest surface of BODY, and
// the position of TOOL. Then leads TRACKED to x, y, z, and ends when TOOL is there.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <igtlClientSocket.h>
#include <igtlMessageHeader.h>
#include <igtlPolyDataMessage.h>
#include <igtlTransformMessage.h>

namespace {

/// Reads the rest of a message whose header has come. False if its checksum is wrong.
template <class Message>
bool receive(igtl::ClientSocket& socket, const igtl::MessageHeader::Pointer& header, Message& message) {
  message.SetMessageHeader(header);
  message.AllocatePack();
  bool timeout = false;
  socket.Receive(message.GetPackBodyPointer(), message.GetPackBodySize(), timeout);
  return (message.Unpack(1) & igtl::MessageHeader::UNPACK_BODY) != 0;
}

void print_surface(igtl::PolyDataMessage& surface) {
  igtlFloat32 first[3], last[3];
  const int points = surface.GetPoints()->GetNumberOfPoints();
  surface.GetPoints()->GetPoint(0, first), surface.GetPoints()->GetPoint(points - 1, last);
  std::printf("surface %d %d %.9g %.9g %.9g %.9g %.9g %.9g\n", points,
              int(surface.GetPolygons()->GetNumberOfCells()), first[0], first[1], first[2], last[0], last[1],
              last[2]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  const std::string body = argv[2], tool = argv[3];
  const double goal[3] = {std::atof(argv[5]), std::atof(argv[6]), std::atof(argv[7])};
  const igtl::ClientSocket::Pointer socket = igtl::ClientSocket::New();
  if (socket->ConnectToServer("127.0.0.1", std::atoi(argv[1])) != 0) return 1;
  bool has_surface = false;
  for (int count = 0; count < 20000; count++) {
    const igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
    header->InitPack();
    bool timeout = false;
    if (socket->Receive(header->GetPackPointer(), header->GetPackSize(), timeout) != header->GetPackSize())
      return 1;
    header->Unpack();
    const std::string type = header->GetDeviceType(), name = header->GetDeviceName();
    if (type == "POLYDATA" && name == body && !has_surface) {
      const igtl::PolyDataMessage::Pointer surface = igtl::PolyDataMessage::New();
      if (!receive(*socket, header, *surface)) return 3;
      print_surface(*surface);
      has_surface = true;
      const igtl::TransformMessage::Pointer lead = igtl::TransformMessage::New();
      igtl::Matrix4x4 matrix;
      igtl::IdentityMatrix(matrix);
      for (int axis = 0; axis < 3; axis++) matrix[axis][3] = float(goal[axis]);
      lead->SetDeviceName(argv[4]);
      lead->SetMatrix(matrix);
      lead->Pack();
      socket->Send(lead->GetPackPointer(), lead->GetPackSize());
    } else if (type == "TRANSFORM" && name == tool) {
      const igtl::TransformMessage::Pointer pose = igtl::TransformMessage::New();
      if (!receive(*socket, header, *pose)) return 3;
      igtl::Matrix4x4 matrix;
      pose->GetMatrix(matrix);
      double distance = 0;
      for (int axis = 0; axis < 3; axis++) distance += std::pow(double(matrix[axis][3]) - goal[axis], 2);
      if (!has_surface || distance > 1e-4) continue;
      std::printf("tool %.9g %.9g %.9g\n", double(matrix[0][3]), double(matrix[1][3]), double(matrix[2][3]));
      return 0;
    } else {
      socket->Skip(header->GetBodySizeToRead(), 0);
    }
  }
  return 1;
}
