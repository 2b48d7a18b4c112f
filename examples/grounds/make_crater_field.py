#!/usr/bin/env python3
"""Writes the same crater field as 16-bit PNG, ESRI ASCII grid and CSV (standard library only, same bytes every time).

Crater of radius R, depth d (Melosh 1989, simple bowl): inside h = -d + (d + r) q^2, outside h = r q^-3 (q = distance/R, rim height
r = 0.2 d). Heights are rounded to the PNG's grey levels first, so that the three files hold the same field.
"""
import math
import struct
import zlib
from pathlib import Path

NX, NY, SPACING = 81, 61, 0.1            # nodes, nodes, m
LOWEST, HIGHEST = -0.30, 0.10            # m, black and white of the PNG
CRATERS = [                              # x, y, radius, depth [m]
    (2.1, 1.6, 0.9, 0.22), (5.2, 4.1, 1.3, 0.26), (6.6, 1.2, 0.6, 0.15), (1.3, 4.6, 0.5, 0.12), (3.7, 3.2, 0.35, 0.09),
    (4.4, 0.7, 0.4, 0.10), (7.4, 2.9, 0.3, 0.07), (2.9, 5.2, 0.3, 0.08),
]


def height(x, y):
    h = 0.0
    for cx, cy, radius, depth in CRATERS:
        q = math.hypot(x - cx, y - cy) / radius
        rim = 0.2 * depth
        h += -depth + (depth + rim) * q * q if q < 1 else rim / q ** 3
    return h


def grey(h):
    level = round((h - LOWEST) / (HIGHEST - LOWEST) * 65535)
    if not 0 <= level <= 65535:
        raise SystemExit(f"height {h} m is outside {LOWEST}..{HIGHEST} m")
    return level


# The first row is the one with the largest y, as on a map.
rows = [[grey(height(i * SPACING, j * SPACING)) for i in range(NX)] for j in reversed(range(NY))]
metres = [[LOWEST + (HIGHEST - LOWEST) * g / 65535 for g in row] for row in rows]
folder = Path(__file__).resolve().parent / "data"


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


raw = b"".join(b"\0" + struct.pack(f">{NX}H", *row) for row in rows)
(folder / "crater_field.png").write_bytes(
    b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", NX, NY, 16, 0, 0, 0, 0)) +
    chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))

header = f"ncols {NX}\nnrows {NY}\nxllcenter 0\nyllcenter 0\ncellsize {SPACING}\nNODATA_value -9999\n"
(folder / "crater_field.asc").write_text(header + "".join(" ".join(f"{z:.7f}" for z in row) + "\n" for row in metres))
(folder / "crater_field.csv").write_text(
    "# heights in mm, first row y = 6 m, columns x = 0 .. 8 m\n" +
    "".join(",".join(f"{1000 * z:.4f}" for z in row) + "\n" for row in metres))
