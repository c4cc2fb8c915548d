#include "rig/tui/operator_page.h"

#include "rig/tui/page_keys.h"
#include "rig/tui/replay.h"
#include "rig/tui/rig_link.h"
#include "rig/tui/rig_page.h"
#include "rig/tui/terminal.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kRedrawEvery = 100ms;

void take_news(PageState& state, const RigLink::News& news) {
  if (news.status) take_status(state, *news.status);
  const auto age = std::chrono::steady_clock::now() - news.answered;
  state.status_age_s = std::chrono::duration<double>(age).count();
  state.trouble = news.trouble;
}

void take_answers(PageState& state, RigLink::Answers answers) {
  if (!answers.messages.empty()) state.message = answers.messages.back();
  if (!answers.takes) return;
  state.takes = std::move(*answers.takes);
  state.selected = std::min(state.selected, state.takes.empty() ? 0 : state.takes.size() - 1);
}

void pass_on(PageState& state, const PageRequest& request, RigLink& link, Replay& replay) {
  if (request.kind == PageRequest::Kind::play)
    state.message = replay.start(request.take);
  else
    link.ask(request, state.status ? state.status->takes_folder : std::filesystem::path());
}

}  // namespace

std::string run_operator_page(const std::filesystem::path& daemon_socket, std::stop_token stop) {
  Terminal terminal;
  RigLink link(daemon_socket);
  Replay replay;
  PageState state;
  while (!stop.stop_requested() && !state.quit && !terminal.gone()) {
    take_news(state, link.news());
    take_answers(state, link.take_answers());
    if (auto message = replay.ended()) state.message = std::move(*message);
    terminal.draw(lay_out(state, terminal.size()));
    if (const auto key = terminal.read_key(kRedrawEvery))
      if (const auto request = press(state, *key)) pass_on(state, *request, link, replay);
  }
  return recording(state) ? state.status->take.name : "";
}

}  // namespace rotunda::rig
