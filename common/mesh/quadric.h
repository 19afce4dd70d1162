// Quadratic error functions of points with attributes.
#pragma once

#include <Eigen/Core>
#include <array>

namespace voxcarve {

/// The function q(z) = z'Az + 2 b'z + c of the displacement z from an origin that the owner of the quadric knows, with
/// A symmetric and q >= 0 everywhere. N = 3 for positions, 6 for positions with colours.
///
/// The origin lies where the function is small, at the vertex that it belongs to, and follows that vertex: no digits
/// are lost as they would be where large terms about a common origin cancel.
///
/// The compiler is told to inline what an evaluation consists of: it pays for calls with copies of matrices.
template <int N>
class Quadric {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// Zero everywhere.
  Quadric() = default;

  /// weight times the squared distance of the position, the first three coordinates, to the plane through the origin
  /// with this unit normal [GH97, 5.1].
  static Quadric of_plane(const Eigen::Vector3d& normal, double weight) {
    Matrix matrix = Matrix::Zero();
    matrix.template topLeftCorner<3, 3>() = weight * normal * normal.transpose();
    return Quadric(matrix);
  }

  /// weight times the squared distance to the plane, two-dimensional whatever N, through the origin along `first` and
  /// `second` [GH98, 3]. Directions that are zero, or the same, span less; then it is the distance to what they span.
  static Quadric of_span(const Vector& first, const Vector& second, double weight) {
    const Vector a = direction(first);
    const Vector b = direction(second - a.dot(second) * a);
    return Quadric(weight * (Matrix::Identity() - a * a.transpose() - b * b.transpose()));
  }

  Quadric& operator+=(const Quadric& other) {
    for (std::size_t i = 0; i < kEntries; ++i) matrix_[i] += other.matrix_[i];
    linear_ += other.linear_;
    constant_ += other.constant_;
    return *this;
  }

  /// The sum of two, as a function of the displacement from the middle between their origins, which lies `half` from
  /// the first and -`half` from the second.
  [[gnu::always_inline]] static Quadric sum_about_middle(const Quadric& first, const Quadric& second,
                                                         const Vector& half) {
    Quadric result = first;
    result += second;
    const Vector first_image = first.times(half);
    const Vector second_image = second.times(half);
    result.constant_ += half.dot(2 * (first.linear_ - second.linear_) + first_image + second_image);
    result.linear_ += first_image - second_image;
    return result;
  }

  /// The same function of the displacement from an origin that lies `step` from the old one.
  Quadric moved(const Vector& step) const {
    Quadric result = *this;
    const Vector image = times(step);
    result.constant_ += step.dot(2 * linear_ + image);
    result.linear_ += image;
    return result;
  }

  double operator()(const Vector& displacement) const {
    return constant_ + displacement.dot(2 * linear_ + times(displacement));
  }

  /// Sum of the eigenvalues of A: what a displacement by 1 costs at most, and on average over all directions N times.
  double trace() const {
    double sum = 0;
    for (int row = 0; row < N; ++row) sum += matrix_[entry(row, row)];
    return sum;
  }

  struct Minimum {
    Vector displacement;
    double value = 0;
  };

  /// Where the function is least. Where it is flat, or flatter than 1e-10 of its trace, the shortest displacement of
  /// them: the minimum of q + 1e-10 trace |z|^2, which comes a share of 1e-10 or so nearer to the origin than the true
  /// one along the steep directions.
  [[gnu::always_inline]] Minimum minimum() const {
    constexpr double kRegularization = 1e-10;
    const double extra = kRegularization * trace();
    if (!(extra > 0)) return {Vector::Zero(), constant_};
    Matrix regular = matrix();
    for (int i = 0; i < N; ++i) regular(i, i) += extra;
    const Vector z = solve<N>(regular, -linear_);
    return {z, constant_ + z.dot(linear_) - extra * z.squaredNorm()};  // Az = -b - extra z
  }

 private:
  static constexpr std::size_t kEntries = N * (N + 1) / 2;

  explicit Quadric(const Matrix& matrix) {
    for (int row = 0; row < N; ++row) {
      for (int column = row; column < N; ++column) matrix_[entry(row, column)] = matrix(row, column);
    }
  }

  static Vector direction(const Vector& vector) {
    const double length = vector.norm();
    return length > 0 ? Vector(vector / length) : Vector(Vector::Zero());
  }

  /// Where A's entry of this row and column, row <= column, lies in matrix_.
  static constexpr std::size_t entry(int row, int column) {
    return static_cast<std::size_t>(row * N - row * (row - 1) / 2 + column - row);
  }

  [[gnu::always_inline]] Matrix matrix() const {
    Matrix full;
    for (int row = 0; row < N; ++row) {
      for (int column = row; column < N; ++column) full(row, column) = full(column, row) = matrix_[entry(row, column)];
    }
    return full;
  }

  [[gnu::always_inline]] Vector times(const Vector& v) const {
    if constexpr (N == 3) {  // written out, for the compiler makes loops of the products below
      const auto& m = matrix_;
      return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
              m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};
    } else {
      return matrix() * v;
    }
  }

  /// Elimination without pivoting, which is stable for positive definite matrices [GvL13, 4.2]; a recursion over the
  /// size, so that all of it unrolls.
  template <int Size>
  [[gnu::always_inline]] static Eigen::Matrix<double, Size, 1> solve(const Eigen::Matrix<double, Size, Size>& matrix,
                                                                     const Eigen::Matrix<double, Size, 1>& right) {
    const double pivot = 1 / matrix(0, 0);
    if constexpr (Size == 1) {
      return pivot * right;
    } else {
      const Eigen::Matrix<double, Size - 1, 1> row = matrix.template bottomLeftCorner<Size - 1, 1>();
      const Eigen::Matrix<double, Size - 1, 1> factor = pivot * row;
      const Eigen::Matrix<double, Size - 1, 1> rest =
          solve<Size - 1>(matrix.template bottomRightCorner<Size - 1, Size - 1>() - factor * row.transpose(),
                          right.template tail<Size - 1>() - right[0] * factor);
      Eigen::Matrix<double, Size, 1> solution;
      solution[0] = pivot * (right[0] - row.dot(rest));
      solution.template tail<Size - 1>() = rest;
      return solution;
    }
  }

  std::array<double, kEntries> matrix_{};  ///< upper triangle of A, row by row
  Vector linear_ = Vector::Zero();         ///< b
  double constant_ = 0;                    ///< c
};

}  // namespace voxcarve
