"use strict";
// Points of the machine's frame O on a canvas, seen from any side without perspective.
const Space = (() => {
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const add = (a, b, f = 1) => [a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]];
  // The point at `p` of a frame given by the columns of its axes and its origin.
  const at = (frame, p) => [0, 1, 2].map((i) => frame[0][i] * p[0] + frame[1][i] * p[1] + frame[2][i] * p[2] + frame[3][i]);
  const corners = ([low, high]) => [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((i) => ((k >> i) & 1 ? high : low)[i]));
  const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
  // Frame of a place: x, y, z in mm, yaw, pitch, roll in degrees, seen from the frame `base`.
  function frameOf([x, y, z, yaw, pitch, roll], base) {
    const [a, b, c] = [yaw, pitch, roll].map((v) => (v * Math.PI) / 180);
    const [ca, sa, cb, sb, cc, sc] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b), Math.cos(c), Math.sin(c)];
    const own = [
      [ca * cb, sa * cb, -sb],
      [ca * sb * sc - sa * cc, sa * sb * sc + ca * cc, cb * sc],
      [ca * sb * cc + sa * sc, sa * sb * cc - ca * sc, cb * cc],
    ];
    const turned = own.map((axis) => add(at(base, axis), base[3], -1));
    return [...turned, at(base, [x, y, z])];
  }
  // The columns of a rotation that is turned by `angle`, rad, about a unit vector.
  function turned(columns, axis, angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return columns.map((v) => {
      const cross = [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]];
      return [0, 1, 2].map((i) => c * v[i] + s * cross[i] + (1 - c) * dot(axis, v) * axis[i]);
    });
  }
  // Roll, pitch and yaw about fixed axes, degrees, of the columns of a rotation.
  function angles([x, y, z]) {
    const isUpright = Math.hypot(x[0], x[1]) > 1e-9;
    const roll = isUpright ? Math.atan2(y[2], z[2]) : 0;
    const yaw = isUpright ? Math.atan2(x[1], x[0]) : Math.atan2(-y[0], y[1]);
    return [roll, Math.atan2(-x[2], Math.hypot(x[0], x[1])), yaw].map((v) => (v * 180) / Math.PI);
  }
  function hull(points) {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    const half = (list) => list.reduce((kept, p) => {
      while (kept.length > 1 && cross(kept[kept.length - 2], kept[kept.length - 1], p) <= 0) kept.pop();
      kept.push(p);
      return kept;
    }, []);
    return half(sorted).slice(0, -1).concat(half(sorted.reverse()).slice(0, -1));
  }
  const inside = (polygon, [x, y]) => polygon.reduce((within, [ax, ay], i) => {
    const [bx, by] = polygon[(i + 1) % polygon.length];
    return (ay > y) !== (by > y) && x < ((bx - ax) * (y - ay)) / (by - ay) + ax ? !within : within;
  }, false);

  // A canvas that shows `box` (corners in O) along the axes `right` and `up`.
  function view(canvas, right, up, box) {
    const context = canvas.getContext("2d");
    const own = { canvas, right, up, scale: 1, centre: [0, 0] };
    let size = [0, 0];
    own.fit = () => {
      const ratio = window.devicePixelRatio || 1;
      size = [canvas.clientWidth, canvas.clientHeight];
      if (canvas.width !== Math.round(size[0] * ratio)) canvas.width = Math.round(size[0] * ratio);
      if (canvas.height !== Math.round(size[1] * ratio)) canvas.height = Math.round(size[1] * ratio);
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      const seen = corners(box).map((p) => [dot(p, own.right), dot(p, own.up)]);
      const ends = [0, 1].map((i) => [Math.min(...seen.map((p) => p[i])), Math.max(...seen.map((p) => p[i]))]);
      own.centre = ends.map(([low, high]) => 0.5 * (low + high));
      const room = ends.map(([low, high], i) => (size[i] - 36) / Math.max(high - low, 1e-9));
      own.scale = Math.min(...room);
    };
    own.to = (p) => [
      0.5 * size[0] + own.scale * (dot(p, own.right) - own.centre[0]),
      0.5 * size[1] - own.scale * (dot(p, own.up) - own.centre[1]),
    ];
    // The way in O that a way on the canvas stands for.
    own.way = (dx, dy) => add([0, 0, 0].map((_, i) => own.right[i] * dx / own.scale), own.up, -dy / own.scale);
    own.clear = () => {
      own.fit();
      context.clearRect(0, 0, size[0], size[1]);
    };
    own.line = (points, colour, width = 1, dash = []) => {
      context.beginPath();
      points.forEach((p, i) => context[i ? "lineTo" : "moveTo"](...own.to(p)));
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.lineJoin = "round";
      context.stroke();
      context.setLineDash([]);
    };
    own.area = (points, fill, stroke, width = 1, dash = []) => {
      const polygon = hull(points.map(own.to));
      context.beginPath();
      polygon.forEach((p, i) => context[i ? "lineTo" : "moveTo"](...p));
      context.closePath();
      if (fill) {
        context.fillStyle = fill;
        context.fill();
      }
      context.strokeStyle = stroke;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.stroke();
      context.setLineDash([]);
      return polygon;
    };
    own.edges = (points, colour, width = 1, dash = []) => EDGES.forEach(([a, b]) => own.line([points[a], points[b]], colour, width, dash));
    own.dot = (p, radius, fill, stroke) => {
      context.beginPath();
      context.arc(...own.to(p), radius, 0, 2 * Math.PI);
      if (fill) {
        context.fillStyle = fill;
        context.fill();
      }
      if (stroke) {
        context.strokeStyle = stroke;
        context.lineWidth = 2;
        context.stroke();
      }
    };
    own.arrow = (from, to, colour) => {
      own.line([from, to], colour, 2.5);
      const [a, b] = [own.to(from), own.to(to)];
      const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
      if (Math.hypot(b[0] - a[0], b[1] - a[1]) < 4) return;
      context.beginPath();
      context.moveTo(...b);
      for (const turn of [2.7, -2.7]) context.lineTo(b[0] + 10 * Math.cos(angle + turn), b[1] + 10 * Math.sin(angle + turn));
      context.closePath();
      context.fillStyle = colour;
      context.fill();
    };
    own.text = (p, words, colour, dx = 7, dy = -7) => {
      const [x, y] = own.to(p);
      context.font = "12px system-ui, sans-serif";
      context.fillStyle = colour;
      context.fillText(words, x + dx, y + dy);
    };
    own.cell = (low, high, colour) => {
      const [a, b] = [own.to(low), own.to(high)];
      context.fillStyle = colour;
      context.fillRect(Math.min(a[0], b[0]) - 0.3, Math.min(a[1], b[1]) - 0.3, Math.abs(b[0] - a[0]) + 0.6, Math.abs(b[1] - a[1]) + 0.6);
    };
    return own;
  }
  return { view, at, add, dot, corners, frameOf, turned, angles, hull, inside };
})();
