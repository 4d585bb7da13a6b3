"""What the papers print, to be stood beside what comes out here.

[DF] M. S. Drew, G. D. Finlayson, "Multispectral processing without spectra", JOSA A 20 (2003) 1181-1193.
"""

__all__ = [
    "METAMER_TABLES",
    "PAIR_SPLITS",
    "RANDOM_TABLES",
    "SIGNALS",
    "THREE_BOUNCES",
]

Row = tuple[float, ...]

# {table: {(p, method): over 1 to 5 reflections}}; p is 0 where the row has none
RANDOM_TABLES: dict[int, dict[tuple[int, str], Row]] = {
    1: {
        (3, "best linear model"): (3.06, 3.24, 3.62, 4.27, 4.86),
        (5, "best linear model"): (0.95, 0.96, 1.12, 1.34, 1.70),
        (7, "best linear model"): (0.44, 0.55, 0.70, 1.02, 1.26),
        (9, "best linear model"): (0.13, 0.16, 0.19, 0.21, 0.24),
        (3, "eq. 12"): (3.92, 4.39, 5.48, 7.04, 8.40),
        (5, "eq. 12"): (2.51, 2.92, 3.58, 4.35, 6.25),
        (7, "eq. 12"): (1.13, 1.31, 1.44, 1.78, 2.09),
        (9, "eq. 12"): (0.88, 1.04, 1.15, 1.25, 1.81),
        (0, "multiply XYZ"): (1.76, 1.99, 2.27, 2.67, 3.16),
    },
    2: {
        (3, "best linear model"): (3.31, 3.66, 3.85, 4.57, 5.19),
        (5, "best linear model"): (0.98, 1.03, 1.21, 1.36, 1.77),
        (7, "best linear model"): (0.46, 0.63, 0.81, 1.13, 1.37),
        (9, "best linear model"): (0.14, 0.18, 0.21, 0.22, 0.25),
        (3, "eq. 12"): (4.12, 4.95, 5.75, 7.44, 9.45),
        (5, "eq. 12"): (2.67, 3.06, 3.75, 4.74, 6.96),
        (7, "eq. 12"): (1.19, 1.40, 1.48, 1.83, 2.21),
        (9, "eq. 12"): (0.92, 1.18, 1.26, 1.31, 1.94),
        (0, "multiply XYZ"): (1.86, 2.02, 2.35, 2.82, 3.58),
    },
    3: {
        (3, "best linear model"): (9.11, 9.28, 9.76, 10.42, 11.14),
        (5, "best linear model"): (4.80, 4.83, 4.75, 4.80, 5.26),
        (7, "best linear model"): (3.03, 3.29, 3.77, 4.28, 4.83),
        (9, "best linear model"): (2.26, 2.32, 2.64, 2.77, 3.17),
        (3, "eq. 12"): (10.35, 10.59, 10.97, 11.65, 13.10),
        (5, "eq. 12"): (7.59, 7.50, 7.35, 7.90, 8.61),
        (7, "eq. 12"): (5.17, 5.61, 5.98, 6.75, 7.96),
        (9, "eq. 12"): (5.04, 5.68, 6.21, 6.58, 7.28),
    },
}

# {table: {(method, light): over 1 to 6 reflections}}, a basis of 7 of the six metamers under both lights
METAMER_TABLES: dict[int, dict[tuple[str, str], Row]] = {
    4: {
        ("best linear model", "D65"): (2.20, 1.02, 4.36, 2.89, 6.60, 5.41),
        ("best linear model", "A"): (1.03, 2.39, 0.86, 0.62, 3.65, 3.86),
        ("eq. 12", "D65"): (1.69, 1.18, 4.72, 3.40, 9.23, 4.51),
        ("eq. 12", "A"): (6.22, 6.16, 9.48, 10.39, 17.39, 20.28),
        ("multiply XYZ", "D65"): (3.95, 4.20, 8.22, 10.08, 17.50, 15.99),
        ("multiply XYZ", "A"): (18.24, 18.94, 27.83, 29.90, 43.92, 37.65),
    },
    5: {
        ("best linear model", "D65"): (3.01, 2.64, 5.65, 5.28, 8.88, 9.09),
        ("best linear model", "A"): (2.48, 3.95, 4.41, 4.04, 8.71, 9.11),
        ("eq. 12", "D65"): (4.20, 3.84, 7.40, 6.44, 11.70, 11.37),
        ("eq. 12", "A"): (17.00, 21.90, 14.01, 16.45, 14.68, 16.63),
    },
}

# Sections 3.A, 3.C and 3.E.1: {(what, method, of what): value}, the last "mean", "median" or "95 %"
SIGNALS: dict[tuple[str, str, str], float] = {
    ("signals, RMS %", "best linear model, p = 7", "mean"): 5.48,
    ("signals, RMS %", "best linear model, p = 7", "median"): 2.97,
    ("lights, RMS %", "best linear model, p = 7", "mean"): 2.69,
    ("lights, RMS %", "best linear model, p = 7", "median"): 2.58,
    ("lights, RMS %", "boxes", "mean"): 33.00,
    ("lights, RMS %", "boxes", "median"): 30.62,
    ("signals, XYZ %", "best linear model, p = 7", "mean"): 0.75,
    ("signals, XYZ %", "best linear model, p = 7", "median"): 0.42,
    ("signals, difference", "best linear model, p = 7", "mean"): 0.92,
    ("signals, difference", "best linear model, p = 7", "median"): 0.42,
    ("signals, difference", "best linear model, p = 7", "95 %"): 3.04,
    ("signals, difference", "boxes", "mean"): 7.15,
    ("signals, difference", "boxes", "median"): 6.74,
    ("signals, difference", "boxes", "95 %"): 14.72,
    ("products, difference", "eq. 12, p = 7", "mean"): 2.21,
    ("products, difference", "eq. 12, p = 7", "median"): 1.14,
    ("products, difference", "boxes", "mean"): 5.50,
    ("products, difference", "boxes", "median"): 4.76,
    ("signals, XYZ %", "best linear model, p = 5", "median"): 0.99,
    ("products, XYZ %", "eq. 12, p = 5", "median"): 3.6,
}

# Section 3.D: {(basis, what, method): over 1 to 3 reflections}
THREE_BOUNCES: dict[tuple[str, str, str], Row] = {
    ("D65", "RMS %", "best linear model"): (6.50, 8.57, 10.98),
    ("D65", "RMS %", "eq. 12"): (7.28, 10.14, 16.82),
    ("D65", "XYZ apart", "best linear model"): (10.99, 0.32, 0.14),
    ("D65", "XYZ apart", "eq. 12"): (23.64, 3.83, 1.74),
    ("D65", "difference", "best linear model"): (1.69, 0.28, 0.28),
    ("D65", "difference", "eq. 12"): (2.35, 3.82, 0.84),
    ("FL2", "difference", "best linear model"): (0.71, 0.20, 0.14),
    ("FL2", "difference", "eq. 12"): (3.71, 3.74, 0.57),
}
THREE_BOUNCES_XYZ = ((400.7, 374.6, 288.5), (45.3, 49.3, 17.5), (8.7, 10.3, 5.8))

# Section 3.E.2: CIE 1976 differences within the three pairs, {(method, light): (3,)}
PAIR_SPLITS: dict[tuple[str, str], Row] = {
    ("full spectra", "D65"): (0.0, 0.0, 0.0),
    ("full spectra", "A"): (34.51, 24.34, 22.31),
    ("multiply XYZ", "D65"): (6.41, 4.30, 4.14),
    ("multiply XYZ", "A"): (3.69, 2.12, 2.18),
}
PAIR_ERROR = 7.42  # median difference from the truth of the six under A, eq. 12 at p = 7
