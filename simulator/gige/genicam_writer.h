#pragma once
// Writes GenICam nodes (GenApi 1.1 schema), a feature and the register behind it at a time.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace rotunda::simulator {

// One number of the camera: a register, and the node that shows it.
struct IntegerFeature {
  std::string_view name;
  std::uint32_t address;
  std::string_view access;
  std::int64_t min, max;
  int bytes = 4;
  std::string_view sign = "Unsigned";
  std::int64_t step = 1;
  std::string_view unit = "";
  std::string_view max_node = "";  // takes the place of `max`
};

// A number with a unit: the register holds round(value * scale).
struct FloatFeature {
  std::string_view name;
  std::uint32_t address;
  std::string_view access, unit;
  double scale, min, max;
  std::string_view selector = "";  // the register is this node's value words further on
};

struct Entry {
  std::string_view name;
  std::uint32_t value;
};

struct Category {
  std::string_view name;
  std::vector<std::string_view> features;
};

class GenicamWriter {
 public:
  GenicamWriter();

  void category(const Category& group);
  void text(std::string_view name, std::uint32_t address, int bytes, std::string_view access = "RO");
  void integer(const IntegerFeature& feature);
  void floating(const FloatFeature& feature);
  void boolean(std::string_view name, std::uint32_t address, std::string_view selector = "");
  void command(std::string_view name, std::uint32_t address, int value = 1);
  void enumeration(std::string_view name, std::uint32_t address, std::string_view access,
                   const std::vector<Entry>& entries, const std::vector<std::string_view>& selected = {});
  // The node `selector` says which of those `features` are.
  void selector(std::string_view name, std::uint32_t address, const std::vector<Entry>& entries,
                const std::vector<std::string_view>& features);
  // Some bits of a word, as a register NAMEReg; GenICam counts bits of a big-endian word from its most significant one.
  void bits(std::string_view name, std::uint32_t address, int first, int last);
  void masked_integer(std::string_view name, std::uint32_t address, int first, int last, std::int64_t min,
                      std::int64_t max);
  void raw(std::string_view more) { text_ += more; }

  std::string finished() &&;

 private:
  struct Register {
    std::string_view name;  // of the feature
    std::uint32_t address;
    std::string_view access = "RW";
    int bytes = 4;
    std::string_view sign = "Unsigned";
    std::string_view selector = "";
  };
  // The name of the register's node, which is written only once: features may share it.
  std::string register_of(const Register& wanted, std::string_view suffix = "Reg");

  std::map<std::uint32_t, std::string> registers_;  // names by address
  std::string text_;
};

}  // namespace rotunda::simulator
