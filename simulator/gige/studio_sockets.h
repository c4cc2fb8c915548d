#pragma once
// The sockets a simulated studio listens and sends on. They throw DeviceError when an address or port is not to be
// had, and InvalidInput for what is no address.
#include <vector>

#include "simulator/gige/camera_options.h"
#include "simulator/gige/udp_socket.h"

namespace rotunda::simulator {

// Throws InvalidInput if two cameras share a name, serial, address or MAC.
void check_distinct(const std::vector<GigeCameraOptions>& cameras);

UdpSocket control_socket(const GigeCameraOptions& camera);  // GVCP's port on the camera's address
UdpSocket stream_socket(const GigeCameraOptions& camera);   // never fragments, as cameras do not
std::vector<UdpSocket> broadcast_sockets();                 // discovery and actions come by broadcast
UdpSocket trigger_box_socket(std::uint16_t port);           // 0: the kernel chooses

}  // namespace rotunda::simulator
