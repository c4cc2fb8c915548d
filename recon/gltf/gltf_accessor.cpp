#include "recon/gltf/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

template <class T>
double load(const unsigned char* bytes, bool normalised) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  const auto number = static_cast<double>(value);
  if (!normalised || !std::numeric_limits<T>::is_integer) return number;
  return std::max(number / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

double load(const unsigned char* bytes, int type, bool normalised) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return load<std::int8_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load<std::uint8_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return load<std::int16_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load<std::uint32_t>(bytes, normalised);
    default:
      return load<float>(bytes, false);
  }
}

std::size_t size_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

std::size_t components_of(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      return 0;
  }
}

}  // namespace

void GltfAccessors::refuse(const std::string& use, const std::string& what) const {
  throw broken(file_.path, fmt::format("{}: {}", use, what));
}

const tinygltf::Accessor& GltfAccessors::at(int accessor, const std::string& use) const {
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= file_.model.accessors.size())
    refuse(use, fmt::format("there is no accessors[{}]", accessor));
  return file_.model.accessors[static_cast<std::size_t>(accessor)];
}

std::size_t GltfAccessors::count(int accessor, const std::string& use) const {
  return at(accessor, use).count;
}

// Where `count` elements of `size` bytes lie, `stride` apart (0: one after another), all of them within their view.
const unsigned char* GltfAccessors::bytes(int view, std::size_t offset, std::size_t stride, std::size_t count,
                                          std::size_t size, const std::string& use) const {
  const auto& views = file_.model.bufferViews;
  if (view < 0 || static_cast<std::size_t>(view) >= views.size())
    refuse(use, fmt::format("there is no bufferViews[{}]", view));
  const auto& found = views[static_cast<std::size_t>(view)];
  if (found.buffer < 0 || static_cast<std::size_t>(found.buffer) >= file_.model.buffers.size())
    refuse(use, fmt::format("bufferViews[{}]: there is no buffers[{}]", view, found.buffer));
  const auto& data = file_.model.buffers[static_cast<std::size_t>(found.buffer)].data;
  if (found.byteOffset > data.size() || found.byteLength > data.size() - found.byteOffset)
    refuse(use, fmt::format("bufferViews[{}]: {} bytes from {} on reach beyond the buffer's {}", view, found.byteLength,
                            found.byteOffset, data.size()));
  const std::size_t step = stride == 0 ? size : stride;
  if (step < size) refuse(use, fmt::format("bufferViews[{}]: a stride of {} for {} bytes", view, stride, size));
  const std::size_t room = found.byteLength;
  if (count > 0 && (offset > room || size > room - offset || (count - 1) > (room - offset - size) / step))
    refuse(use, fmt::format("{} elements do not fit in the {} bytes of bufferViews[{}]", count, room, view));
  return data.data() + found.byteOffset + offset;
}

void GltfAccessors::lay_sparse(const tinygltf::Accessor& accessor, std::size_t components, const std::string& use,
                               std::vector<double>& values) const {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count)
    refuse(use, fmt::format("{} sparse elements of {}", sparse.count, accessor.count));
  const auto count = static_cast<std::size_t>(sparse.count);
  const std::size_t index_size = size_of(sparse.indices.componentType), size = size_of(accessor.componentType);
  const bool is_index = index_size != 0 && sparse.indices.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT &&
                        sparse.indices.componentType != TINYGLTF_COMPONENT_TYPE_BYTE &&
                        sparse.indices.componentType != TINYGLTF_COMPONENT_TYPE_SHORT;
  if (!is_index) refuse(use, "sparse indices of an unknown type");
  const auto offset = [&](auto value) {
    if (value < 0) refuse(use, "a negative sparse offset");
    return static_cast<std::size_t>(value);
  };
  const auto* index = bytes(sparse.indices.bufferView, offset(sparse.indices.byteOffset), 0, count, index_size, use);
  const auto* value =
      bytes(sparse.values.bufferView, offset(sparse.values.byteOffset), 0, count, size * components, use);
  for (std::size_t i = 0; i < count; ++i) {
    const auto element = static_cast<std::size_t>(load(index + i * index_size, sparse.indices.componentType, false));
    if (element >= accessor.count) refuse(use, fmt::format("sparse index {} of {}", element, accessor.count));
    for (std::size_t c = 0; c < components; ++c)
      values[element * components + c] =
          load(value + (i * components + c) * size, accessor.componentType, accessor.normalized);
  }
}

std::vector<double> GltfAccessors::read(int index, std::size_t components, const std::string& use, bool integers_only) {
  const auto& accessor = at(index, use);
  const std::size_t size = size_of(accessor.componentType);
  if (components_of(accessor.type) != components)
    refuse(use, fmt::format("accessors[{}] has {} components instead of {}", index, components_of(accessor.type),
                            components));
  if (size == 0 || (integers_only && accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT))
    refuse(use, fmt::format("accessors[{}] has numbers of type {}", index, accessor.componentType));
  if (accessor.count > budget_ / components)
    throw InvalidInput(
        fmt::format("{}: {}: {} elements more than can be taken", file_.path.string(), use, accessor.count));
  budget_ -= accessor.count * components;
  const bool is_there = accessor.bufferView >= 0;
  const unsigned char* from = nullptr;
  std::size_t stride = size * components;
  if (is_there) {
    const auto& views = file_.model.bufferViews;
    const bool known = static_cast<std::size_t>(accessor.bufferView) < views.size();
    if (known && views[static_cast<std::size_t>(accessor.bufferView)].byteStride != 0)
      stride = views[static_cast<std::size_t>(accessor.bufferView)].byteStride;
    from = bytes(accessor.bufferView, accessor.byteOffset, stride, accessor.count, size * components, use);
  }
  std::vector<double> values(accessor.count * components, 0.0);
  for (std::size_t i = 0; is_there && i < accessor.count; ++i)
    for (std::size_t c = 0; c < components; ++c)
      values[i * components + c] =
          load(from + i * stride + c * size, accessor.componentType, accessor.normalized && !integers_only);
  if (accessor.sparse.isSparse) lay_sparse(accessor, components, use, values);
  return values;
}

std::vector<float> GltfAccessors::numbers(int accessor, std::size_t components, const std::string& use) {
  const auto values = read(accessor, components, use, false);
  std::vector<float> numbers(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i]) <= 1e9))
      refuse(use, fmt::format("element {} of accessors[{}] is {}", i / components, accessor, values[i]));
    numbers[i] = static_cast<float>(values[i]);
  }
  return numbers;
}

std::vector<float> GltfAccessors::colours(int accessor, const std::string& use) {
  if (components_of(at(accessor, use).type) == 4) return numbers(accessor, 4, use);
  const auto rgb = numbers(accessor, 3, use);
  std::vector<float> rgba;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) rgba.insert(rgba.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 1.0F});
  return rgba;
}

std::vector<std::uint32_t> GltfAccessors::integers(int accessor, std::size_t components, const std::string& use) {
  const auto values = read(accessor, components, use, true);
  std::vector<std::uint32_t> integers(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] < 0.0) refuse(use, fmt::format("element {} of accessors[{}] is negative", i / components, accessor));
    integers[i] = static_cast<std::uint32_t>(values[i]);
  }
  return integers;
}

}  // namespace rotunda::recon
