#include "capture/take/take_journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFile = "events.jsonl";
constexpr std::size_t kLongestText = 4096;  // bytes of a remark; more is cut

[[noreturn]] void fail(const fs::path& file, int error, const char* what) {
  throw std::system_error(error, std::generic_category(), fmt::format("{} {}", what, file.string()));
}

std::map<CameraId, HoleReason> reasons_in(const json& cameras) {
  std::map<CameraId, HoleReason> reasons;
  for (const auto& [camera, why] : cameras.items())
    reasons[camera] = hole_reason_from(why.get<std::string>()).value_or(HoleReason::not_recorded);
  return reasons;
}

// Throws json::exception for what is not as documented.
void read_line(const json& line, TakeJournal& journal) {
  const auto trigger = line.at("trigger").get<std::uint64_t>();
  if (line.contains("missing")) journal.missing[trigger].merge(reasons_in(line["missing"]));
  if (line.contains("mark")) journal.marks.push_back({trigger, line["mark"].get<std::string>()});
  if (line.contains("incident")) journal.incidents.push_back({trigger, line["incident"].get<std::string>()});
}

json remark_line(const char* kind, const TakeRemark& remark) {
  return {{"trigger", remark.trigger}, {kind, remark.text.substr(0, kLongestText)}};
}

// Text from a terminal may be no UTF-8: what is not becomes U+FFFD.
std::string text_of(const json& line) {
  return line.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace

TakeJournal read_take_journal(const fs::path& folder) {
  TakeJournal journal;
  const fs::path file = folder / kFile;
  if (!fs::exists(file)) return journal;
  std::ifstream stream(file);
  if (!stream) fail(file, errno, "cannot read");
  std::string text;
  for (std::size_t number = 1; std::getline(stream, text); ++number) {
    const bool cut_short = stream.eof();
    try {
      read_line(json::parse(text), journal);
    } catch (const json::exception&) {
      if (!cut_short) journal.problems.push_back(fmt::format("{}: line {} is damaged", file.string(), number));
    }
  }
  return journal;
}

TakeJournalWriter::TakeJournalWriter(const fs::path& folder)
    : file_(folder / kFile), fd_(::open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (!fd_) fail(file_, errno, "cannot write");
}

void TakeJournalWriter::append(const std::string& line) {
  struct stat before {};
  if (::fstat(fd_.get(), &before) != 0) fail(file_, errno, "cannot write");
  const ssize_t written = ::write(fd_.get(), line.data(), line.size());
  if (written == static_cast<ssize_t>(line.size())) return;
  const int error = written < 0 ? errno : ENOSPC;
  static_cast<void>(::ftruncate(fd_.get(), before.st_size));
  fail(file_, error, "cannot write");
}

void TakeJournalWriter::missing(std::uint64_t trigger, const std::map<CameraId, HoleReason>& cameras) {
  json reasons = json::object();
  for (const auto& [camera, why] : cameras) reasons[camera] = to_string(why);
  append(text_of({{"trigger", trigger}, {"missing", reasons}}));
}

void TakeJournalWriter::mark(const TakeRemark& mark) {
  append(text_of(remark_line("mark", mark)));
}

void TakeJournalWriter::incident(const TakeRemark& incident) {
  append(text_of(remark_line("incident", incident)));
}

void TakeJournalWriter::sync() const {
  if (::fdatasync(fd_.get()) != 0) fail(file_, errno, "cannot bring to disk");
}

}  // namespace rotunda::capture
