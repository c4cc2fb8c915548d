#pragma once
// Writing the settings of a GenICam camera, each read back: what the camera does not take is a DeviceError
// that names the camera, its answer and what to do; CameraGone if there is no answer.
#include <string>

#include "capture/source/aravis_handle.h"
#include "capture/source/source.h"
#include "config/errors.h"

namespace rotunda::capture {

// A camera that no longer answers.
class CameraGone : public DeviceError {
  using DeviceError::DeviceError;
};

// The user set, then region, pixel format, exposure, gain, white balance, trigger, features by name. The answer's
// warnings are what the camera has otherwise than asked.
SourceDescription configure_camera(ArvCamera* camera, const SourceSettings& settings);

// How a GigE Vision camera's packets come to us. Throws DeviceError if the asked packet size does not fit the link.
struct StreamChannel {
  int packet_size = 0;
  bool packet_socket = false;
  bool on_loopback = false;
  std::string link;  // network interface
  double link_bits_per_second = 0.0;
};
StreamChannel configure_stream_channel(ArvCamera* camera, const SourceSettings& settings);
// Streams created from now on have none.
void forgo_packet_socket(ArvCamera* camera);

// Throws DeviceError if the camera takes no packet delay; one that knows no start delay starts at once.
void configure_pacing(ArvCamera* camera, const SourceSettings& settings, const StreamPacing& pacing);

void start_acquisition(ArvCamera* camera, const SourceSettings& settings);
void stop_acquisition(ArvCamera* camera, const SourceSettings& settings);
// DeviceIndicatorMode of the SFNC; false if the camera has none, or does not take it.
bool set_indicator_light(ArvCamera* camera, bool on);
void fire_software_trigger(ArvCamera* camera, const SourceSettings& settings);
std::size_t payload_bytes(ArvCamera* camera, const SourceSettings& settings, const SourceDescription& description);
GRef<ArvStream> create_stream(ArvCamera* camera, const SourceSettings& settings, ArvStreamCallback callback,
                              void* user_data);

}  // namespace rotunda::capture
