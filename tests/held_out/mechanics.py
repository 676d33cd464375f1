"""The arm, computed from its files in another way than the program's: M as the sum of J^T I J over the bodies,
K_g from second derivatives of each body's height, eigenvalues by Jacobi's rotations in the longest float there is."""

import collections
import json
import math

import numpy as np

LONGEST = np.longdouble  # 80 bits on x86
CHUNK = 10_000
G0 = 9.80665


def rpy(angles, dtype=float):
    """Fixed axes x, y, z: Rz Ry Rx."""
    r, p, y = (dtype(a) for a in angles)
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ],
        dtype=dtype,
    )


def unit(v, dtype=float):
    v = np.array(v, dtype=dtype)
    return v / np.sqrt((v * v).sum())


def cross(a, b):
    """Vectors or stacks of them; numpy's own takes five times as long for a few."""
    (ax, ay, az), (bx, by, bz) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (a, b))
    out = np.empty(np.broadcast_shapes(a.shape, b.shape), dtype=np.result_type(a, b))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out


def about(axis, angles):
    """Rotations about one axis by a vector of angles."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=axis.dtype)
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3, dtype=axis.dtype) + s * k + (1 - c) * (k @ k)


def jacobi_eigenvalues(a):
    """Eigenvalues of a stack of symmetric positive definite matrices, ascending; any float type."""
    a = a.copy()
    n = a.shape[1]
    tiny = np.finfo(a.dtype).tiny
    for _ in range(30):
        d = np.einsum("kii->ki", a)
        off = np.abs(a) / np.sqrt(np.abs(d[:, :, None] * d[:, None, :]))
        off[:, range(n), range(n)] = 0
        if off.max() < 8 * np.finfo(a.dtype).eps:
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                apq = a[:, p, q].copy()
                rotate = np.abs(apq) > tiny
                theta = (a[:, q, q] - a[:, p, p]) / np.where(rotate, 2 * apq, 1)
                t = np.where(theta >= 0, 1, -1) / (np.abs(theta) + np.hypot(theta, 1))
                t = np.where(rotate, t, 0)
                c = 1 / np.sqrt(t * t + 1)
                s = t * c
                cp, cq = a[:, :, p].copy(), a[:, :, q].copy()
                a[:, :, p], a[:, :, q] = c[:, None] * cp - s[:, None] * cq, s[:, None] * cp + c[:, None] * cq
                rp, rq = a[:, p, :].copy(), a[:, q, :].copy()
                a[:, p, :], a[:, q, :] = c[:, None] * rp - s[:, None] * rq, s[:, None] * rp + c[:, None] * rq
    return np.sort(np.einsum("kii->ki", a), axis=1)


def rotation_log(r):
    """Rotation vectors of a rotation matrix or a stack of them; angles well below pi."""
    skew = 0.5 * np.stack([r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], axis=-1)
    sine = np.linalg.norm(skew, axis=-1)
    angle = np.arctan2(sine, 0.5 * (np.trace(r, axis1=-2, axis2=-1) - 1))
    return skew * np.where(sine > 0, angle / np.where(sine > 0, sine, 1), 1)[..., None]


def rotation_exp(v):
    """The rotation matrix of a rotation vector, or a stack of them (Rodrigues)."""
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    zero = np.zeros(v.shape[:-1])
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    k = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*v.shape[:-1], 3, 3)
    safe = np.where(angle > 1e-9, angle, 1)
    sine = np.where(angle > 1e-9, np.sin(safe) / safe, 1)
    cosine = np.where(angle > 1e-9, (1 - np.cos(safe)) / safe**2, 0.5)
    return np.eye(3) + sine * k + cosine * (k @ k)


def rpy_angles(r):
    """Roll, pitch and yaw of a rotation matrix: the inverse of `rpy`."""
    return np.array([math.atan2(r[2, 1], r[2, 2]), math.atan2(-r[2, 0], math.hypot(r[2, 1], r[2, 2])), math.atan2(r[1, 0], r[0, 0])])


def frame(spec):
    spec = spec or {}
    return rpy(spec.get("rpy_rad", [0, 0, 0])), np.array(spec.get("xyz_m", [0, 0, 0]), dtype=float)


class Robot:
    """links: [{name, mass, com, rpy, inertia} | {name}]; joints: [{name, type, parent, child, xyz, rpy, axis, lower,
    upper, velocity}]; yaml: the content of robot.yaml."""

    def __init__(self, links, joints, yaml):
        self.links, self.joints, self.yaml = links, joints, yaml
        self.above = {j["child"]: j for j in joints}
        self.turns = {}
        names = [l["name"] for l in links]
        root = next(n for n in names if n not in self.above)
        self.base = yaml.get("base", root)
        below = collections.defaultdict(list)
        for j in joints:
            below[j["parent"]].append(j["child"])
        self.order = [self.base]
        for n in self.order:
            self.order += below[n]
        if "tip" in yaml:
            self.tip = yaml["tip"]
        else:
            moving = [n for n in self.order[1:] if self.above[n]["type"] != "fixed"]
            self.tip = max(moving, key=lambda n: len(self.path(n)))
        self.chain = [self.above[n] for n in self.path(self.tip)[1:]]
        self.moving = [j for j in self.chain if j["type"] != "fixed"]
        self.names = [j["name"] for j in self.moving]
        self.lower = np.array([j.get("lower", -np.inf) if j["type"] != "continuous" else -np.inf for j in self.moving])
        self.upper = np.array([j.get("upper", np.inf) if j["type"] != "continuous" else np.inf for j in self.moving])
        self.velocity = np.array([j.get("velocity", np.nan) for j in self.moving])
        self.slides = np.array([j["type"] == "prismatic" for j in self.moving])
        elasticity = yaml["elasticity"]
        self.default_damping = elasticity.get("damping_ratio", 0.02)
        self.gravity = elasticity.get("gravity", False)
        self.gravity_vector = elasticity.get("gravity_m_per_s2", [0, 0, -G0])
        drives = yaml.get("drives", {})
        self.coordinates = []
        for n in self.order:
            j = self.above.get(n)
            spring = elasticity.get("joints", {}).get(j["name"]) if j is not None and n != self.base else None
            if spring is not None:
                k = spring.get("stiffness_nm_per_rad", spring.get("stiffness_n_per_m"))
                drive = drives.get(j["name"], {}).get("reflected_inertia_kgm2", 0.0)
                zeta = spring.get("damping_ratio", self.default_damping)
                self.coordinates.append((n, j["type"] == "prismatic", j["axis"], [0, 0, 0], k, zeta, drive))
            for e in elasticity.get("extra", []):
                if e["link"] == n:
                    zeta = e.get("damping_ratio", self.default_damping)
                    self.coordinates.append(
                        (n, e["kind"] == "translation", e["axis"], e.get("origin_m", [0, 0, 0]), e["stiffness"], zeta, 0.0)
                    )
        self.n = len(self.coordinates)
        self.k = np.array([c[4] for c in self.coordinates], dtype=float)
        self.zeta = np.array([c[5] for c in self.coordinates], dtype=float)
        self.drive = np.array([c[6] for c in self.coordinates], dtype=float)
        carried = {n: self.path(n, self.base) for n in self.order}
        self.carries = {
            n: [i for i, c in enumerate(self.coordinates) if c[0] in carried[n]] for n in self.order
        }
        self.bodies = []
        for l in links:
            if l["name"] in carried and l.get("mass", 0.0) > 0.0:
                self.bodies.append((l["name"], l["mass"], l["com"], l["rpy"], tensor(l["inertia"])))
        payload = yaml.get("payload")
        if payload and payload["mass_kg"] > 0:
            inertia = tensor(payload["inertia_kgm2"]) if "inertia_kgm2" in payload else np.zeros((3, 3))
            self.bodies.append((payload["link"], payload["mass_kg"], payload.get("com_m", [0, 0, 0]), [0, 0, 0], inertia))
        calibration = yaml.get("calibration")
        self.uncertainty = 2 * calibration["heldout_rms_percent"] if calibration else 10.0

    def path(self, link, until=None):
        found = [link]
        until = until if until is not None else self.base
        while found[-1] != until and found[-1] in self.above:
            found.append(self.above[found[-1]]["parent"])
        return found[::-1]

    def turn_of(self, joint, dtype):
        """How a joint's frame is turned where the joint stands at zero; computed once."""
        key = (joint["name"], dtype)
        if key not in self.turns:
            self.turns[key] = rpy(joint["rpy"], dtype)
        return self.turns[key]

    def place(self, q):
        """World (base) rotation and origin of every link, at poses q (N x joints); dtype of q."""
        dtype = q.dtype.type
        n = len(q)
        frames = {self.base: (np.broadcast_to(np.eye(3, dtype=dtype), (n, 3, 3)), np.zeros((n, 3), dtype=dtype))}
        column = {j["name"]: i for i, j in enumerate(self.moving)}
        for link in self.order[1:]:
            j = self.above[link]
            r0, p0 = frames[j["parent"]]
            p = p0 + r0 @ np.array(j["xyz"], dtype=dtype)
            r = r0 @ self.turn_of(j, dtype)
            if j["type"] != "fixed":
                axis = unit(j["axis"], dtype)
                if j["name"] in column:
                    value = q[:, column[j["name"]]]
                else:  # off the chain: held at zero, or at the limit nearest to it
                    held = 0.0
                    if j["type"] != "continuous" and "lower" in j:
                        held = min(max(0.0, j["lower"]), j["upper"])
                    value = np.full(n, held, dtype=dtype)
                if j["type"] == "prismatic":
                    p = p + (r @ axis) * value[:, None]
                else:
                    r = r @ about(axis, value)
            frames[link] = (r, p)
        return frames

    def matrices(self, q):
        """M, K (N x n x n) and the frames."""
        dtype = q.dtype.type
        frames = self.place(q)
        n = len(q)
        axes, origins = [], []
        for link, _, axis, origin, *_ in self.coordinates:
            r, p = frames[link]
            axes.append(r @ unit(axis, dtype))
            origins.append(p + r @ np.array(origin, dtype=dtype))
        slides = [c[1] for c in self.coordinates]
        m = np.zeros((n, self.n, self.n), dtype=dtype)
        g = np.zeros((n, self.n, self.n), dtype=dtype)
        gravity = np.array(self.gravity_vector, dtype=dtype)
        for link, mass, com, turn, inertia in self.bodies:
            who = self.carries[link]
            if not who:
                continue
            r, p = frames[link]
            c = p + r @ np.array(com, dtype=dtype)
            rb = r @ rpy(turn, dtype)
            world = rb @ np.array(inertia, dtype=dtype) @ rb.swapaxes(1, 2)
            jv = np.stack([axes[i] if slides[i] else cross(axes[i], c - origins[i]) for i in who], axis=2)
            jw = np.stack([np.zeros_like(axes[i]) if slides[i] else axes[i] for i in who], axis=2)
            part = dtype(mass) * (jv.swapaxes(1, 2) @ jv) + jw.swapaxes(1, 2) @ (world @ jw)
            m[np.ix_(range(n), who, who)] += part
            if self.gravity:
                for a, i in enumerate(who):
                    if slides[i]:
                        continue
                    for b in range(a, len(who)):
                        # i is nearer to the base: the second derivative is the turn of the outer one's velocity.
                        bend = -dtype(mass) * (cross(axes[i], jv[:, :, b]) @ gravity)
                        g[:, i, who[b]] += bend
                        if b != a:
                            g[:, who[b], i] += bend
        d = np.arange(self.n)
        m[:, d, d] += self.drive.astype(dtype)
        g[:, d, d] += self.k.astype(dtype)
        return m, g, frames, axes, origins

    def scaled(self, q):
        """L^-1 M L^-T with K = L L^T, and L."""
        m, k, *rest = self.matrices(q)
        if not self.gravity:
            root = np.sqrt(self.k.astype(q.dtype))
            return m / (root[:, None] * root[None, :]), None, rest
        n = self.n
        low = np.zeros_like(k)
        for j in range(n):
            pivot = k[:, j, j] - (low[:, j, :j] ** 2).sum(axis=1)
            low[:, j, j] = np.sqrt(pivot)
            for i in range(j + 1, n):
                low[:, i, j] = (k[:, i, j] - (low[:, i, :j] * low[:, j, :j]).sum(axis=1)) / low[:, j, j]
        x = m
        for _ in range(2):
            x = x.copy()
            for i in range(n):
                x[:, i, :] = (x[:, i, :] - np.einsum("kj,kjc->kc", low[:, i, :i], x[:, :i, :])) / low[:, i, i][:, None]
            x = x.swapaxes(1, 2)
        return 0.5 * (x + x.swapaxes(1, 2)), low, rest

    def frequencies(self, q):
        """Hz, ascending; in the float type of q."""
        out = []
        for i in range(0, len(q), CHUNK):
            a = self.scaled(q[i : i + CHUNK])[0]
            values = jacobi_eigenvalues(a) if q.dtype == LONGEST else np.linalg.eigvalsh(a)
            out.append((1 / (2 * np.pi * np.sqrt(values)))[:, ::-1])
        return np.concatenate(out)

    def modes(self, q, tcp):
        """f (Hz), zeta, |J phi|^2 / (2 zeta omega^2) in um/N per mode; tcp in the tip frame."""
        fs, zs, ts = [], [], []
        for i in range(0, len(q), CHUNK):
            part = q[i : i + CHUNK].astype(float)
            a, low, (frames, axes, origins) = self.scaled(part)
            values, vectors = np.linalg.eigh(a)
            values, vectors = values[:, ::-1], vectors[:, :, ::-1]
            omega = 1 / np.sqrt(values)
            if low is None:
                phi = vectors / np.sqrt(self.k)[:, None] * omega[:, None, :]
            else:
                phi = np.linalg.solve(low.swapaxes(1, 2), vectors) * omega[:, None, :]
            energy = self.k[:, None] * phi**2
            zeta = (self.zeta[:, None] * energy).sum(axis=1) / energy.sum(axis=1)
            r, p = frames[self.tip]
            point = p + r @ np.array(tcp, dtype=float)
            j = np.zeros((len(part), 3, self.n))
            for c in self.carries[self.tip]:
                j[:, :, c] = axes[c] if self.coordinates[c][1] else cross(axes[c], point - origins[c])
            moved = ((j @ phi) ** 2).sum(axis=1)
            fs.append(omega / (2 * np.pi))
            zs.append(zeta)
            ts.append(1e6 * moved / (2 * zeta * omega**2))
        return np.concatenate(fs), np.concatenate(zs), np.concatenate(ts)

    def tool(self, q, tcp_r, tcp_p):
        """Rotation and origin of the tool centre point, and the 6 x joints Jacobian there."""
        frames = self.place(q)
        r, p = frames[self.tip]
        point = p + r @ np.asarray(tcp_p, dtype=q.dtype)
        jac = np.zeros((len(q), 6, len(self.moving)), dtype=q.dtype)
        for i, j in enumerate(self.moving):
            rj, pj = frames[j["child"]]
            a = rj @ unit(j["axis"], q.dtype.type)
            if j["type"] == "prismatic":
                jac[:, :3, i] = a
            else:
                jac[:, :3, i] = cross(a, point - pj)
                jac[:, 3:, i] = a
        return r @ np.asarray(tcp_r, dtype=q.dtype), point, jac

    def solve_pose(self, r_goal, p_goal, tcp_r, tcp_p, q, steps=12):
        """Newton from q (N x joints) to the poses; the joints and the residual."""
        q = q.copy()
        for _ in range(steps):
            r, p, jac = self.tool(q, tcp_r, tcp_p)
            turn = rotation_log(r_goal @ r.swapaxes(1, 2))
            error = np.concatenate([p_goal - p, turn], axis=1)
            if np.abs(error).max() < 1e-13:
                break
            q = q + np.linalg.solve(jac, error[:, :, None])[:, :, 0]
        r, p, jac = self.tool(q, tcp_r, tcp_p)
        turn = rotation_log(r_goal @ r.swapaxes(1, 2))
        return q, np.abs(np.concatenate([p_goal - p, turn], axis=1)).max(axis=1)

    def urdf(self):
        t = lambda v: " ".join(repr(float(x)) for x in v)
        out = ['<?xml version="1.0"?>', '<robot name="held_out">']
        for l in self.links:
            if "mass" not in l:
                out.append(f'  <link name="{l["name"]}"/>')
                continue
            inertia = " ".join(f'{k}="{float(v)!r}"' for k, v in l["inertia"].items())
            out.append(
                f'  <link name="{l["name"]}">\n    <inertial>\n      <origin xyz="{t(l["com"])}" rpy="{t(l["rpy"])}"/>\n'
                f'      <mass value="{float(l["mass"])!r}"/>\n      <inertia {inertia}/>\n    </inertial>\n  </link>'
            )
        for j in self.joints:
            out.append(f'  <joint name="{j["name"]}" type="{j["type"]}">')
            out.append(f'    <parent link="{j["parent"]}"/>\n    <child link="{j["child"]}"/>')
            out.append(f'    <origin xyz="{t(j["xyz"])}" rpy="{t(j["rpy"])}"/>')
            if j["type"] != "fixed":
                out.append(f'    <axis xyz="{t(j["axis"])}"/>')
                limits = [f'{k}="{float(j[k])!r}"' for k in ("lower", "upper", "velocity") if k in j]
                out.append(f'    <limit effort="1000" {" ".join(limits)}/>')
            out.append("  </joint>")
        return "\n".join(out + ["</robot>", ""])


def tensor(i):
    xy, xz, yz = i.get("ixy", 0.0), i.get("ixz", 0.0), i.get("iyz", 0.0)
    return np.array([[i["ixx"], xy, xz], [xy, i["iyy"], yz], [xz, yz, i["izz"]]])


def yaml_of(value):
    """YAML from plain data: block at the top, flow below."""
    return "\n".join(f"{key}: {json.dumps(item)}" for key, item in value.items()) + "\n"
