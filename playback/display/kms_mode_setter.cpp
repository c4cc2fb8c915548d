#include "playback/display/kms_mode_setter.h"

#include <fcntl.h>
#include <xf86drm.h>

#include <initializer_list>
#include <map>
#include <string>

namespace rotunda::playback {
namespace {

using AtomicRequest = DrmPtr<drmModeAtomicReq, drmModeAtomicFree>;
using PropertyIds = std::map<std::string, std::uint32_t, std::less<>>;

PropertyIds property_ids(int fd, std::uint32_t object, std::uint32_t type) {
  PropertyIds ids;
  const DrmPtr<drmModeObjectProperties, drmModeFreeObjectProperties> all{drmModeObjectGetProperties(fd, object, type)};
  for (std::uint32_t i = 0; all && i < all->count_props; ++i) {
    const DrmPtr<drmModePropertyRes, drmModeFreeProperty> property{drmModeGetProperty(fd, all->props[i])};
    if (property) ids[property->name] = property->prop_id;
  }
  return ids;
}

// The plane that fills the CRTC's picture; 0: none.
std::uint32_t primary_plane(int fd, std::size_t crtc_place) {
  const DrmPtr<drmModePlaneRes, drmModeFreePlaneResources> planes{drmModeGetPlaneResources(fd)};
  for (std::uint32_t i = 0; planes && i < planes->count_planes; ++i) {
    const DrmPtr<drmModePlane, drmModeFreePlane> plane{drmModeGetPlane(fd, planes->planes[i])};
    if (plane && (plane->possible_crtcs >> crtc_place & 1U) != 0 &&
        property_value(fd, plane->plane_id, DRM_MODE_OBJECT_PLANE, "type") == DRM_PLANE_TYPE_PRIMARY)
      return plane->plane_id;
  }
  return 0;
}

// A mode as the kernel's property value.
class ModeBlob {
 public:
  ModeBlob(int fd, const drmModeModeInfo& mode) : fd_(fd) { drmModeCreatePropertyBlob(fd, &mode, sizeof mode, &id_); }
  ~ModeBlob() { drmModeDestroyPropertyBlob(fd_, id_); }
  ModeBlob(const ModeBlob&) = delete;
  ModeBlob& operator=(const ModeBlob&) = delete;
  std::uint32_t id() const { return id_; }

 private:
  int fd_;
  std::uint32_t id_ = 0;
};

class AtomicSetter final : public ModeSetter {
 public:
  AtomicSetter(int fd, const KmsPath& path, std::uint32_t plane)
      : fd_(fd),
        path_(path),
        plane_(plane),
        of_connector_(property_ids(fd, path.connector, DRM_MODE_OBJECT_CONNECTOR)),
        of_crtc_(property_ids(fd, path.crtc, DRM_MODE_OBJECT_CRTC)),
        of_plane_(property_ids(fd, plane, DRM_MODE_OBJECT_PLANE)) {}

  const char* name() const override { return "atomic"; }

  bool light(const drmModeModeInfo& mode, std::uint32_t framebuffer) override {
    const ModeBlob blob(fd_, mode);
    const AtomicRequest request{drmModeAtomicAlloc()};
    set(*request, path_.connector, of_connector_, {{"CRTC_ID", path_.crtc}});
    if (of_connector_.contains("link-status"))
      set(*request, path_.connector, of_connector_, {{"link-status", DRM_MODE_LINK_STATUS_GOOD}});
    set(*request, path_.crtc, of_crtc_, {{"MODE_ID", blob.id()}, {"ACTIVE", 1}});
    const std::uint64_t width = mode.hdisplay, height = mode.vdisplay;
    set(*request, plane_, of_plane_,
        {{"FB_ID", framebuffer},
         {"CRTC_ID", path_.crtc},
         {"SRC_X", 0},
         {"SRC_Y", 0},
         {"SRC_W", width << 16},  // 16.16 fixed point
         {"SRC_H", height << 16},
         {"CRTC_X", 0},
         {"CRTC_Y", 0},
         {"CRTC_W", width},
         {"CRTC_H", height}});
    return commit(*request, DRM_MODE_ATOMIC_TEST_ONLY | DRM_MODE_ATOMIC_ALLOW_MODESET) &&
           commit(*request, DRM_MODE_ATOMIC_ALLOW_MODESET);
  }

  bool flip(std::uint32_t framebuffer, void* told) override {
    const AtomicRequest request{drmModeAtomicAlloc()};
    set(*request, plane_, of_plane_, {{"FB_ID", framebuffer}});
    return commit(*request, DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, told);
  }

  void darken() override {
    const AtomicRequest request{drmModeAtomicAlloc()};
    set(*request, path_.connector, of_connector_, {{"CRTC_ID", 0}});
    set(*request, path_.crtc, of_crtc_, {{"MODE_ID", 0}, {"ACTIVE", 0}});
    set(*request, plane_, of_plane_, {{"FB_ID", 0}, {"CRTC_ID", 0}});
    commit(*request, DRM_MODE_ATOMIC_ALLOW_MODESET);
  }

 private:
  struct Setting {
    const char* name;
    std::uint64_t value;
  };

  static void set(drmModeAtomicReq& request, std::uint32_t object, const PropertyIds& ids,
                  std::initializer_list<Setting> settings) {
    for (const auto& [name, value] : settings)
      if (const auto id = ids.find(name); id != ids.end())
        drmModeAtomicAddProperty(&request, object, id->second, value);
  }

  bool commit(drmModeAtomicReq& request, std::uint32_t flags, void* told = nullptr) const {
    return drmModeAtomicCommit(fd_, &request, flags, told) == 0;
  }

  int fd_;
  KmsPath path_;
  std::uint32_t plane_;
  PropertyIds of_connector_, of_crtc_, of_plane_;
};

class LegacySetter final : public ModeSetter {
 public:
  LegacySetter(int fd, const KmsPath& path) : fd_(fd), path_(path) {}

  const char* name() const override { return "legacy"; }
  bool light(const drmModeModeInfo& mode, std::uint32_t framebuffer) override {
    auto wanted = mode;
    auto connector = path_.connector;
    return drmModeSetCrtc(fd_, path_.crtc, framebuffer, 0, 0, &connector, 1, &wanted) == 0;
  }
  bool flip(std::uint32_t framebuffer, void* told) override {
    return drmModePageFlip(fd_, path_.crtc, framebuffer, DRM_MODE_PAGE_FLIP_EVENT, told) == 0;
  }
  void darken() override { drmModeSetCrtc(fd_, path_.crtc, 0, 0, 0, nullptr, 0, nullptr); }

 private:
  int fd_;
  KmsPath path_;
};

}  // namespace

std::unique_ptr<ModeSetter> make_atomic_setter(const KmsCard& card, const KmsPath& path) {
  if (drmSetClientCap(card.fd(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1) != 0 ||
      drmSetClientCap(card.fd(), DRM_CLIENT_CAP_ATOMIC, 1) != 0)
    return nullptr;
  const auto plane = primary_plane(card.fd(), path.crtc_place);
  return plane == 0 ? nullptr : std::make_unique<AtomicSetter>(card.fd(), path, plane);
}

std::unique_ptr<ModeSetter> make_legacy_setter(const KmsCard& card, const KmsPath& path) {
  drmSetClientCap(card.fd(), DRM_CLIENT_CAP_ATOMIC, 0);
  return std::make_unique<LegacySetter>(card.fd(), path);
}

CrtcBefore::CrtcBefore(const KmsCard& card, const KmsPath& path)
    : fd_(card.fd()), path_(path), crtc_(drmModeGetCrtc(card.fd(), path.crtc)) {}

void CrtcBefore::restore() {
  if (!crtc_) return;
  auto connector = path_.connector;
  const bool shown =
      crtc_->mode_valid != 0 && crtc_->buffer_id != 0 &&
      drmModeSetCrtc(fd_, path_.crtc, crtc_->buffer_id, crtc_->x, crtc_->y, &connector, 1, &crtc_->mode) == 0;
  if (!shown) drmModeSetCrtc(fd_, path_.crtc, 0, 0, 0, nullptr, 0, nullptr);
  crtc_.reset();
}

}  // namespace rotunda::playback
