#pragma once
// A sparse Cholesky factor for many right-hand sides: CHOLMOD orders (METIS) and factorises in double, the factor is
// kept in float32, supernode by supernode, rows together. A solve reads it twice however many right-hand sides there
// are, so these lie side by side, a vector register each (Highway).
#include <Eigen/SparseCore>
#include <cstdint>
#include <span>
#include <vector>

namespace rotunda::recon {

// Columns first ... first + columns of L share the pattern of their rows below. Values row by row: the triangle of the
// diagonal block (its diagonal inverted), then the rows below.
struct Supernode {
  std::uint32_t first = 0, columns = 0;
  std::uint32_t rows_below = 0;
  std::size_t row_start = 0, value_start = 0;
};

struct SparseFactor {
  std::vector<Supernode> supernodes;
  std::vector<std::uint32_t> rows;  // of all supernodes, below their diagonal blocks
  std::vector<float> values;
  std::vector<int> order;  // order[i]: the matrix's row that stands at i in the factor
};

// `lower`: the lower triangle of a symmetric positive definite matrix. Throws InvalidInput if it is not definite.
SparseFactor factorise(const Eigen::SparseMatrix<double>& lower);

}  // namespace rotunda::recon
