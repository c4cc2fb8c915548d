#include "recon/deform/sparse_factor.h"

#include <suitesparse/cholmod.h>

#include <memory>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

class Common {
 public:
  Common() {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
    common_.print = 0;
  }
  ~Common() { cholmod_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_;
};

cholmod_sparse view_of(const Eigen::SparseMatrix<double>& lower) {
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(lower.rows());
  view.ncol = static_cast<std::size_t>(lower.cols());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.x = const_cast<double*>(lower.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

// CHOLMOD's supernodes are dense, column by column; ours row by row and without the upper triangle.
void append(const cholmod_factor& factor, std::size_t s, SparseFactor& result) {
  const auto* super = static_cast<const int*>(factor.super);
  const auto* first_row = static_cast<const int*>(factor.pi);
  const auto* first_value = static_cast<const int*>(factor.px);
  const auto* rows = static_cast<const int*>(factor.s) + first_row[s];
  const auto* values = static_cast<const double*>(factor.x) + first_value[s];
  const auto columns = static_cast<std::size_t>(super[s + 1] - super[s]);
  const auto height = static_cast<std::size_t>(first_row[s + 1] - first_row[s]);
  result.supernodes.push_back({static_cast<std::uint32_t>(super[s]), static_cast<std::uint32_t>(columns),
                               static_cast<std::uint32_t>(height - columns), result.rows.size(), result.values.size()});
  for (std::size_t r = 0; r < height; ++r) {
    if (r >= columns) result.rows.push_back(static_cast<std::uint32_t>(rows[r]));
    for (std::size_t c = 0; c < std::min(r + 1, columns); ++c) {
      const double value = values[c * height + r];
      result.values.push_back(static_cast<float>(c == r ? 1.0 / value : value));
    }
  }
}

}  // namespace

SparseFactor factorise(const Eigen::SparseMatrix<double>& lower) {
  SparseFactor result;
  if (lower.rows() == 0) return result;
  Common common;
  auto view = view_of(lower);
  const auto free_factor = [&](cholmod_factor* factor) { cholmod_free_factor(&factor, common.get()); };
  const std::unique_ptr<cholmod_factor, decltype(free_factor)> factor(cholmod_analyze(&view, common.get()),
                                                                      free_factor);
  if (!factor || !cholmod_factorize(&view, factor.get(), common.get()) || common.get()->status != CHOLMOD_OK ||
      factor->minor < factor->n)
    throw InvalidInput("the surface's Laplacian cannot be factorised: part of the surface is held nowhere");
  result.values.reserve(factor->xsize);
  result.rows.reserve(factor->ssize);
  for (std::size_t s = 0; s < factor->nsuper; ++s) append(*factor, s, result);
  const auto* order = static_cast<const int*>(factor->Perm);
  result.order.assign(order, order + factor->n);
  return result;
}

}  // namespace rotunda::recon
