#pragma once
// Sets a mode and flips pages on one connector and CRTC: atomically where the driver can, else by the older calls.
#include <cstdint>
#include <memory>
#include <optional>

#include "playback/display/kms_card.h"

namespace rotunda::playback {

struct KmsPath {
  std::uint32_t connector = 0, crtc = 0;
  std::size_t crtc_place = 0;  // among the device's CRTCs
};

class ModeSetter {
 public:
  ModeSetter() = default;
  virtual ~ModeSetter() = default;
  ModeSetter(const ModeSetter&) = delete;
  ModeSetter& operator=(const ModeSetter&) = delete;

  virtual const char* name() const = 0;
  // Sets the mode and shows the framebuffer, which is of its size. False: the driver refuses, errno says why.
  virtual bool light(const drmModeModeInfo& mode, std::uint32_t framebuffer) = 0;
  // Shows it from the next refresh on; an event on the device's descriptor tells when, `told` goes with it. False:
  // refused, errno says why.
  virtual bool flip(std::uint32_t framebuffer, void* told) = 0;
  virtual void darken() = 0;  // the CRTC and the connector off
};

// Nothing if the driver cannot.
std::unique_ptr<ModeSetter> make_atomic_setter(const KmsCard& card, const KmsPath& path);
std::unique_ptr<ModeSetter> make_legacy_setter(const KmsCard& card, const KmsPath& path);

// What a CRTC shows, to be shown again: the text console, as a rule.
class CrtcBefore {
 public:
  CrtcBefore(const KmsCard& card, const KmsPath& path);
  ~CrtcBefore() { restore(); }
  CrtcBefore(const CrtcBefore&) = delete;
  CrtcBefore& operator=(const CrtcBefore&) = delete;
  void restore();  // once

 private:
  int fd_;
  KmsPath path_;
  DrmPtr<drmModeCrtc, drmModeFreeCrtc> crtc_;
};

}  // namespace rotunda::playback
