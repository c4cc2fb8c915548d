#include "rig/tui/rig_link.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <utility>

#include "capture/take/take.h"
#include "capture/take/take_edit.h"
#include "recon/live_take.h"
#include "recon/take_studio.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using Kind = PageRequest::Kind;
namespace fs = std::filesystem;

constexpr auto kPollEvery = 250ms;

ListedTake listed(const fs::path& root, const capture::TakeInfo& info) {
  const auto folder = root / info.name;
  ListedTake take{.name = info.name, .slate = info.slate, .note = info.note, .folder = folder};
  take.state = capture::is_interrupted(folder, info) ? "interrupted" : std::string(to_string(info.state));
  take.frame_sets = info.frame_sets;
  take.complete = info.complete_sets;
  take.seconds = info.fps > 0.0 ? static_cast<double>(info.frame_sets) / info.fps : 0.0;
  take.circled = info.circled;
  take.reconstructed = fs::exists(recon::geometry_video_of(folder));
  take.at_live_quality = fs::exists(recon::live_take_file(folder));
  return take;
}

// A take that is recorded belongs to its daemon; any other is edited where it lies.
void edit(RigClient& client, const ListedTake& take, const TakeAnnotation& annotation) {
  const auto info = capture::read_take_info(take.folder);
  if (info.state == capture::TakeState::recording && !capture::is_interrupted(take.folder, info))
    client.annotate_take(annotation);
  else
    capture::edit_take(take.folder, {.note = annotation.note, .slate = {}, .circled = annotation.circled});
}

std::string circle_words(const std::string& take, bool on) {
  return fmt::format("take {} {}", take, on ? "circled" : "no longer circled");
}

}  // namespace

std::vector<ListedTake> listed_takes(const fs::path& takes) {
  auto infos = capture::list_takes(takes);
  std::stable_sort(infos.begin(), infos.end(), [](const auto& a, const auto& b) { return a.recorded > b.recorded; });
  std::vector<ListedTake> list;
  for (const auto& info : infos) list.push_back(listed(takes, info));
  return list;
}

RigLink::RigLink(const fs::path& socket)
    : poll_client_(socket),
      desk_client_(socket),
      news_{.status = {}, .answered = std::chrono::steady_clock::now(), .trouble = ""},
      poll_([this](std::stop_token stop) { poll(std::move(stop)); }),
      desk_([this](std::stop_token stop) { serve(std::move(stop)); }) {}

RigLink::~RigLink() {
  poll_.request_stop();
  desk_.request_stop();
  poll_client_.hang_up();
  desk_client_.hang_up();
}

RigLink::News RigLink::news() const {
  const std::lock_guard lock(mutex_);
  return news_;
}

void RigLink::poll(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "page poll");
  while (!stop.stop_requested()) {
    const auto next = std::chrono::steady_clock::now() + kPollEvery;
    std::optional<RigStatus> status;
    std::string trouble;
    try {
      status = poll_client_.status();
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    std::unique_lock lock(mutex_);
    if (status) news_ = {.status = std::move(status), .answered = std::chrono::steady_clock::now(), .trouble = ""};
    news_.trouble = trouble;
    wake_.wait_until(lock, stop, next, [] { return false; });
  }
}

void RigLink::ask(const PageRequest& request, const fs::path& takes) {
  const std::lock_guard lock(mutex_);
  requests_.emplace_back(request, takes);
  wake_.notify_all();
}

RigLink::Answers RigLink::take_answers() {
  const std::lock_guard lock(mutex_);
  return std::exchange(answers_, {});
}

void RigLink::serve(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "page desk");
  while (!stop.stop_requested()) {
    std::pair<PageRequest, fs::path> next;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, stop, [this] { return !requests_.empty(); });
      if (stop.stop_requested()) return;
      next = std::move(requests_.front());
      requests_.pop_front();
    }
    do_and_tell(next.first, next.second);
  }
}

void RigLink::do_and_tell(const PageRequest& request, const fs::path& takes) {
  std::string message;
  std::optional<std::vector<ListedTake>> list;
  try {
    message = done(request);
    if (request.kind == Kind::list_takes || request.kind == Kind::note_take || request.kind == Kind::circle_take)
      list = listed_takes(takes);
  } catch (const std::exception& error) {
    message = error.what();
  }
  const std::lock_guard lock(mutex_);
  if (!message.empty()) answers_.messages.push_back(std::move(message));
  if (list) answers_.takes = std::move(list);
}

std::string RigLink::done(const PageRequest& request) {
  switch (request.kind) {
    case Kind::arm:
    case Kind::disarm: {
      const auto status = desk_client_.set_live(request.kind == Kind::arm);
      return fmt::format("the rig is {}", status.state);
    }
    case Kind::record: {
      const TakeRequest take{.scene = request.scene, .shot = request.shot};
      const auto begun = desk_client_.start_take(take, [](const TakeProgress&) { return false; }, {});
      return fmt::format("take {} records", begun.name);
    }
    case Kind::stop: {
      const auto take = desk_client_.stop_take();
      return fmt::format("take {} is closed: {} frame sets, {} whole", take.name, take.frame_sets, take.complete);
    }
    case Kind::mark: {
      const auto take = desk_client_.annotate_take({.mark = "mark", .note = {}, .circled = {}});
      return fmt::format("mark {} at frame set {}", take.marks, take.frame_sets);
    }
    case Kind::note:
      return fmt::format("note of take {} kept",
                         desk_client_.annotate_take({.mark = "", .note = request.text, .circled = {}}).name);
    case Kind::circle:
      return circle_words(desk_client_.annotate_take({.mark = "", .note = {}, .circled = request.on}).name, request.on);
    case Kind::note_take:
      edit(desk_client_, request.take, {.mark = "", .note = request.text, .circled = {}});
      return fmt::format("note of take {} kept", request.take.name);
    case Kind::circle_take:
      edit(desk_client_, request.take, {.mark = "", .note = {}, .circled = request.on});
      return circle_words(request.take.name, request.on);
    case Kind::list_takes:
    case Kind::play:
      break;
  }
  return "";
}

}  // namespace rotunda::rig
