#include "rig/messages.h"

namespace rotunda::rig {
namespace {

CameraStatus from_message(const v1::CameraStatus& m) {
  return {.name = m.name(),
          .device = m.device(),
          .state = m.state(),
          .model = m.model(),
          .serial = m.serial(),
          .pixel_format = m.pixel_format(),
          .problem = m.problem(),
          .width = m.width(),
          .height = m.height(),
          .packet_size = m.packet_size(),
          .socket_buffer_bytes = m.socket_buffer_bytes(),
          .frames = m.frames(),
          .incomplete = m.incomplete(),
          .dropped = m.dropped(),
          .resend_requests = m.resend_requests(),
          .rate_hz = m.rate_hz(),
          .missing = {m.missing().begin(), m.missing().end()},
          .clipped = m.has_clipped() ? std::optional(m.clipped()) : std::nullopt,
          .focus = m.has_focus() ? std::optional(m.focus()) : std::nullopt,
          .clock = m.has_clock() ? std::optional(m.clock()) : std::nullopt,
          .clock_offset_us = m.has_clock_offset_us() ? std::optional(m.clock_offset_us()) : std::nullopt,
          .clock_error_us = m.has_clock_error_us() ? std::optional(m.clock_error_us()) : std::nullopt,
          .temperature_c = m.has_temperature_c() ? std::optional(m.temperature_c()) : std::nullopt,
          .offset_us = m.has_offset_us() ? std::optional(m.offset_us()) : std::nullopt,
          .drift_ppm = m.has_drift_ppm() ? std::optional(m.drift_ppm()) : std::nullopt,
          .silent_s = m.silent_s(),
          .address = m.address()};
}

void fill(const CameraStatus& camera, v1::CameraStatus& m) {
  m.set_name(camera.name);
  m.set_device(camera.device);
  m.set_state(camera.state);
  m.set_model(camera.model);
  m.set_serial(camera.serial);
  m.set_pixel_format(camera.pixel_format);
  m.set_problem(camera.problem);
  m.set_width(camera.width);
  m.set_height(camera.height);
  m.set_packet_size(camera.packet_size);
  m.set_socket_buffer_bytes(camera.socket_buffer_bytes);
  m.set_frames(camera.frames);
  m.set_incomplete(camera.incomplete);
  m.set_dropped(camera.dropped);
  m.set_resend_requests(camera.resend_requests);
  m.set_rate_hz(camera.rate_hz);
  m.mutable_missing()->insert(camera.missing.begin(), camera.missing.end());
  if (camera.clipped) m.set_clipped(*camera.clipped);
  if (camera.focus) m.set_focus(*camera.focus);
  if (camera.clock) m.set_clock(*camera.clock);
  if (camera.clock_offset_us) m.set_clock_offset_us(*camera.clock_offset_us);
  if (camera.clock_error_us) m.set_clock_error_us(*camera.clock_error_us);
  if (camera.temperature_c) m.set_temperature_c(*camera.temperature_c);
  if (camera.offset_us) m.set_offset_us(*camera.offset_us);
  if (camera.drift_ppm) m.set_drift_ppm(*camera.drift_ppm);
  m.set_silent_s(camera.silent_s);
  m.set_address(camera.address);
}

LiveSurfacesStatus from_message(const v1::LiveSurfacesStatus& m) {
  return {.state = m.state(),
          .rate_hz = m.rate_hz(),
          .delay_ms = m.delay_ms(),
          .made = m.made(),
          .shed = m.shed(),
          .failed = m.failed(),
          .triangles = m.triangles(),
          .viewers = m.viewers(),
          .problem = m.problem()};
}

void fill(const LiveSurfacesStatus& surfaces, v1::LiveSurfacesStatus& m) {
  m.set_state(surfaces.state);
  m.set_rate_hz(surfaces.rate_hz);
  m.set_delay_ms(surfaces.delay_ms);
  m.set_made(surfaces.made);
  m.set_shed(surfaces.shed);
  m.set_failed(surfaces.failed);
  m.set_triangles(surfaces.triangles);
  m.set_viewers(surfaces.viewers);
  m.set_problem(surfaces.problem);
}

}  // namespace

TakeProgress from_message(const v1::TakeProgress& m) {
  return {.name = m.name(),
          .folder = m.folder(),
          .frame_sets = m.frame_sets(),
          .complete = m.complete(),
          .wanted = m.wanted(),
          .closed = m.closed(),
          .failure = m.failure(),
          .slate = m.slate(),
          .marks = m.marks(),
          .circled = m.circled(),
          .note = m.note(),
          .scene = m.scene(),
          .shot = m.shot(),
          .warnings = {m.warnings().begin(), m.warnings().end()}};
}

v1::TakeProgress to_message(const TakeProgress& progress) {
  v1::TakeProgress m;
  m.set_name(progress.name);
  m.set_folder(progress.folder.string());
  m.set_frame_sets(progress.frame_sets);
  m.set_complete(progress.complete);
  m.set_wanted(progress.wanted);
  m.set_closed(progress.closed);
  m.set_failure(progress.failure);
  m.set_slate(progress.slate);
  m.set_marks(progress.marks);
  m.set_circled(progress.circled);
  m.set_note(progress.note);
  m.set_scene(progress.scene);
  m.set_shot(progress.shot);
  m.mutable_warnings()->Assign(progress.warnings.begin(), progress.warnings.end());
  return m;
}

RigStatus from_message(const v1::Status& m) {
  RigStatus status{.rig = m.rig(), .state = m.state(), .trigger = m.trigger(), .rate_hz = m.rate_hz()};
  status.takes_folder = m.takes_folder();
  status.disk_free_bytes = m.disk_free_bytes();
  status.seconds_left = m.seconds_left();
  status.take = from_message(m.take());
  for (const auto& camera : m.cameras()) status.cameras.push_back(from_message(camera));
  status.late_triggers = m.late_triggers();
  status.late_frames = m.late_frames();
  status.queued_frame_sets = m.queued_frame_sets();
  status.spread_median_us = m.spread_median_us();
  status.spread_p99_us = m.spread_p99_us();
  status.warnings.assign(m.warnings().begin(), m.warnings().end());
  for (const auto& finding : m.preflight())
    status.preflight.push_back({finding.what(), verdict_from(finding.verdict()), finding.measured(), finding.cure()});
  status.surfaces = from_message(m.surfaces());
  return status;
}

v1::Status to_message(const RigStatus& status) {
  v1::Status m;
  m.set_rig(status.rig);
  m.set_state(status.state);
  m.set_trigger(status.trigger);
  m.set_rate_hz(status.rate_hz);
  m.set_takes_folder(status.takes_folder.string());
  m.set_disk_free_bytes(status.disk_free_bytes);
  m.set_seconds_left(status.seconds_left);
  *m.mutable_take() = to_message(status.take);
  for (const auto& camera : status.cameras) fill(camera, *m.add_cameras());
  m.set_late_triggers(status.late_triggers);
  m.set_late_frames(status.late_frames);
  m.set_queued_frame_sets(status.queued_frame_sets);
  m.set_spread_median_us(status.spread_median_us);
  m.set_spread_p99_us(status.spread_p99_us);
  m.mutable_warnings()->Assign(status.warnings.begin(), status.warnings.end());
  for (const auto& finding : status.preflight) {
    auto* added = m.add_preflight();
    added->set_what(finding.what);
    added->set_verdict(to_string(finding.verdict));
    added->set_measured(finding.measured);
    added->set_cure(finding.cure);
  }
  fill(status.surfaces, *m.mutable_surfaces());
  m.set_protocol(1);
  return m;
}

TakeRequest from_message(const v1::StartTakeRequest& m) {
  return {.name = m.name(),
          .frame_sets = m.frame_sets(),
          .duration_s = m.duration_s(),
          .note = m.note(),
          .scene = m.scene(),
          .shot = m.shot()};
}

TakeAnnotation from_message(const v1::AnnotateTakeRequest& m) {
  return {.mark = m.mark(),
          .note = m.has_note() ? std::optional(m.note()) : std::nullopt,
          .circled = m.has_circled() ? std::optional(m.circled()) : std::nullopt};
}

v1::AnnotateTakeRequest to_message(const TakeAnnotation& annotation) {
  v1::AnnotateTakeRequest m;
  m.set_mark(annotation.mark);
  if (annotation.note) m.set_note(*annotation.note);
  if (annotation.circled) m.set_circled(*annotation.circled);
  return m;
}

IdentifyRequest from_message(const v1::IdentifyRequest& m) {
  return {.picture = m.picture(), .camera = m.camera(), .blink = m.blink()};
}

v1::IdentifyRequest to_message(const IdentifyRequest& request) {
  v1::IdentifyRequest m;
  m.set_picture(request.picture.string());
  m.set_camera(request.camera);
  m.set_blink(request.blink);
  return m;
}

std::vector<IdentifiedCamera> from_message(const v1::IdentifyAnswer& m) {
  std::vector<IdentifiedCamera> cameras;
  for (const auto& camera : m.cameras())
    cameras.push_back({.name = camera.name(),
                       .serial = camera.serial(),
                       .address = camera.address(),
                       .model = camera.model(),
                       .problem = camera.problem(),
                       .pictured = camera.pictured(),
                       .blinked = camera.blinked()});
  return cameras;
}

v1::IdentifyAnswer to_message(const std::vector<IdentifiedCamera>& cameras) {
  v1::IdentifyAnswer m;
  for (const auto& camera : cameras) {
    auto* added = m.add_cameras();
    added->set_name(camera.name);
    added->set_serial(camera.serial);
    added->set_address(camera.address);
    added->set_model(camera.model);
    added->set_problem(camera.problem);
    added->set_pictured(camera.pictured);
    added->set_blinked(camera.blinked);
  }
  return m;
}

LivePacket from_message(const v1::LivePacket& m) {
  LivePacket packet;
  packet.surface.assign(m.surface().begin(), m.surface().end());
  for (const auto& picture : m.pictures())
    packet.pictures.push_back({picture.camera(), {picture.jpeg().begin(), picture.jpeg().end()}});
  return packet;
}

v1::LivePacket to_message(const LivePacket& packet) {
  v1::LivePacket m;
  m.mutable_surface()->assign(packet.surface.begin(), packet.surface.end());
  for (const auto& picture : packet.pictures) {
    auto* added = m.add_pictures();
    added->set_camera(picture.camera);
    added->mutable_jpeg()->assign(picture.jpeg.begin(), picture.jpeg.end());
  }
  return m;
}

v1::StartTakeRequest to_message(const TakeRequest& request) {
  v1::StartTakeRequest m;
  m.set_name(request.name);
  m.set_frame_sets(request.frame_sets);
  m.set_duration_s(request.duration_s);
  m.set_note(request.note);
  m.set_scene(request.scene);
  m.set_shot(request.shot);
  return m;
}

PlateReport from_message(const v1::PlateReport& m) {
  PlateReport report{.folder = m.folder()};
  for (const auto& camera : m.cameras())
    report.cameras.push_back({.camera = camera.camera(),
                              .file = camera.file(),
                              .pictures = camera.pictures(),
                              .noise = camera.noise(),
                              .moving_share = camera.moving_share()});
  report.missing.assign(m.missing().begin(), m.missing().end());
  return report;
}

v1::PlateReport to_message(const PlateReport& report) {
  v1::PlateReport m;
  m.set_folder(report.folder.string());
  for (const auto& camera : report.cameras) {
    auto& filled = *m.add_cameras();
    filled.set_camera(camera.camera);
    filled.set_file(camera.file.string());
    filled.set_pictures(camera.pictures);
    filled.set_noise(camera.noise);
    filled.set_moving_share(camera.moving_share);
  }
  m.mutable_missing()->Assign(report.missing.begin(), report.missing.end());
  return m;
}

}  // namespace rotunda::rig
