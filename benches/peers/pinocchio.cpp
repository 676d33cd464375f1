// Natural frequencies (and what each mode moves the tool) of an arm at many poses, by Pinocchio's composite
// rigid bodies and Eigen's eigensolvers: the peer that detune's batch kernel is timed against.
//
//   pinocchio MODEL POSES OUT plain|scaled frequencies|tip
//
// MODEL is the text that run.py writes, POSES and OUT are raw doubles, pose after pose. "plain" hands K and M to
// GeneralizedSelfAdjointEigenSolver; "scaled" hands K^-1/2 M K^-1/2 to SelfAdjointEigenSolver. Prints the least and
// the median ns a pose of several passes.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/multibody.hpp>

namespace pin = pinocchio;

constexpr int PASSES = 15;
constexpr int N = 6;
using Matrix = Eigen::Matrix<double, N, N>;
using Vector = Eigen::Matrix<double, N, 1>;

struct Arm {
  pin::Model model;
  Vector stiffness;
  double damping_ratio;
  // In the last joint's frame.
  Eigen::Vector3d tool;
};

static Arm read_arm(const std::string &file) {
  std::ifstream in(file);
  in.exceptions(std::ios::failbit | std::ios::badbit);
  Arm arm;
  int joints;
  in >> joints;
  if (joints != N) throw std::runtime_error("the program is made for six joints");
  for (int i = 0; i < joints; ++i) {
    int parent;
    Eigen::Vector3d axis, origin, com;
    Eigen::Matrix3d rotation, inertia;
    double mass;
    const auto matrix = [&in](Eigen::Matrix3d &m) {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) in >> m(r, c);
    };
    in >> parent >> axis[0] >> axis[1] >> axis[2];
    matrix(rotation);
    in >> origin[0] >> origin[1] >> origin[2] >> mass >> com[0] >> com[1] >> com[2];
    matrix(inertia);
    in >> arm.stiffness[i];
    const pin::SE3 placement(rotation, origin);
    const std::string name = "joint_" + std::to_string(i + 1);
    pin::JointIndex index;
    // Joints about a frame's own axis are the fast ones.
    if (axis == Eigen::Vector3d::UnitX())
      index = arm.model.addJoint(parent, pin::JointModelRX(), placement, name);
    else if (axis == Eigen::Vector3d::UnitY())
      index = arm.model.addJoint(parent, pin::JointModelRY(), placement, name);
    else if (axis == Eigen::Vector3d::UnitZ())
      index = arm.model.addJoint(parent, pin::JointModelRZ(), placement, name);
    else
      index = arm.model.addJoint(parent, pin::JointModelRevoluteUnaligned(axis), placement, name);
    arm.model.appendBodyToJoint(index, pin::Inertia(mass, com, inertia), pin::SE3::Identity());
  }
  in >> arm.damping_ratio >> arm.tool[0] >> arm.tool[1] >> arm.tool[2];
  return arm;
}

static std::vector<double> read_doubles(const std::string &file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  std::vector<double> values(in.tellg() / sizeof(double));
  in.seekg(0);
  in.read(reinterpret_cast<char *>(values.data()), values.size() * sizeof(double));
  return values;
}

int main(int argc, char **argv) {
  if (argc != 6) {
    std::cerr << "usage: pinocchio MODEL POSES OUT plain|scaled frequencies|tip\n";
    return 2;
  }
  const Arm arm = read_arm(argv[1]);
  const std::vector<double> poses = read_doubles(argv[2]);
  const bool scaled = std::string(argv[4]) == "scaled";
  const bool tip = std::string(argv[5]) == "tip";
  const size_t count = poses.size() / N;
  const size_t width = tip ? 2 * N : N;
  std::vector<double> out(count * width);

  pin::Data data(arm.model);
  const Matrix k = arm.stiffness.asDiagonal();
  const Vector inverse_root = arm.stiffness.cwiseSqrt().cwiseInverse();
  const auto options = tip ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly;
  Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> plain_solver;
  Eigen::SelfAdjointEigenSolver<Matrix> scaled_solver;
  pin::Data::Matrix6x jacobian(6, N);
  Eigen::VectorXd q(N);

  std::vector<double> ns;
  for (int pass = 0; pass < PASSES; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    for (size_t i = 0; i < count; ++i) {
      q = Eigen::Map<const Vector>(poses.data() + i * N);
      pin::crba(arm.model, data, q, pin::Convention::LOCAL);
      Matrix m = data.M;
      m.triangularView<Eigen::StrictlyLower>() = m.transpose().triangularView<Eigen::StrictlyLower>();
      double *row = out.data() + i * width;
      Matrix shapes;
      Vector omega2;
      if (scaled) {
        const Matrix a = inverse_root.asDiagonal() * m * inverse_root.asDiagonal();
        scaled_solver.compute(a, options);
        // Ascending eigenvalues 1/omega^2: descending frequencies.
        omega2 = scaled_solver.eigenvalues().reverse().cwiseInverse();
        if (tip) {
          shapes = inverse_root.asDiagonal() * scaled_solver.eigenvectors().rowwise().reverse() *
                   omega2.cwiseSqrt().asDiagonal();
        }
      } else {
        plain_solver.compute(k, m, options | Eigen::Ax_lBx);
        omega2 = plain_solver.eigenvalues();
        if (tip) shapes = plain_solver.eigenvectors();
      }
      for (int r = 0; r < N; ++r) row[r] = std::sqrt(omega2[r]) / (2.0 * M_PI);
      if (tip) {
        jacobian.setZero();
        pin::computeJointJacobian(arm.model, data, q, N, jacobian);
        // Velocity of the tool in the last joint's frame: lengths are those in any frame.
        Eigen::Matrix<double, 3, N> at_tool = jacobian.topRows<3>();
        for (int c = 0; c < N; ++c)
          at_tool.col(c) += jacobian.block<3, 1>(3, c).cross(arm.tool);
        const Eigen::Matrix<double, 3, N> moved = at_tool * shapes;
        for (int r = 0; r < N; ++r)
          row[N + r] = moved.col(r).squaredNorm() / (2.0 * arm.damping_ratio * omega2[r]);
      }
    }
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
    ns.push_back(spent.count() / count);
  }
  std::sort(ns.begin(), ns.end());
  std::cout << ns.front() << " " << ns[ns.size() / 2] << "\n";
  std::ofstream(argv[3], std::ios::binary)
      .write(reinterpret_cast<const char *>(out.data()), out.size() * sizeof(double));
}
