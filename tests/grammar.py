"""Robot files made up from scratch, each from a number: grammars of URDF, MJCF, SRDF, adapters and xacro.

Where a real file has a name or a figure, one comes from a pool that holds what parsers stumble over; the structure is
that of a robot, or a caricature of one: far too deep, too wide, too long, or in an encoding of its own.
"""

from __future__ import annotations

import random
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

FIGURES = (
    *("0", "1", "-1", "0.5", "3.14159", "-0", "1e-320", "1e308", "-1e308", "1e309", "nan", "inf", "-inf", "NaN"),
    *("1e5", "1e6", "1000001", "1e-9", "0x1p3", "1_000", "1,5", "1.", ".5", "+.5e-3", "--1", "1e", "", " ", "\t2\n"),
    *("9" * 400, "9" * 5000, "0." + "0" * 500 + "1", "1" * 309, "٣", "½", "1\u00a02", "${1/0}", "$(arg x)", "true"),
)
AXES = ("1 0 0", "0 1 0", "0 0 1", "0 0 -1", "1 1 0", "0 0 0", "1e-9 0 0", "1e200 1e200 0", "0.6 0 0.8")
NAMES = (
    *("a", "b", "base_link", "tool0", "universe", "root_joint", "world", "left_hand", "link", "j1", "", " ", "\u202e"),
    *(
        "x" * 1000,
        "x" * 1001,
        "x" * 100_000,
        "é",
        "名前",
        "\U0001f916",
        "a/b",
        "..",
        "%s%n",
        "{0}",
        "${x}",
        "a\nb",
        "\x7f",
    ),
    *(
        "<img src=x onerror=alert(1)>",
        "'; DROP TABLE links;--",
        "]]>",
        "-->",
        "&amp;",
        "\\",
        "con",
        "#",
        "a b",
        "'",
        '"',
    ),
)
ENCODINGS = ("utf-8-sig", "utf-16", "utf-16-le", "utf-32", "iso-8859-1", "cp037", "utf-7", "koi8-r", "cp1252")
DECLARED = (
    "utf-8",
    "UTF-16",
    "iso-8859-1",
    "ebcdic-cp-us",
    "utf-7",
    "zlib",
    "idna",
    "x" * 300,
    "us-ascii",
    "Shift_JIS",
)
BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {chr(98 + k)} "{f"&{chr(97 + k)};" * 10}">' for k in range(12)
)
HEADS = (
    *(
        BOMB + "]>",
        '<!DOCTYPE r SYSTEM "file:///etc/passwd">',
        '<!DOCTYPE r [<!ENTITY % x SYSTEM "http://127.0.0.1:9/"> %x;]>',
    ),
    *(
        "<!-- <!DOCTYPE a> -->",
        "<?php system('id') ?>",
        "<?xml-stylesheet href='x'?>",
        "\ufeff",
        "\0",
        "\n\n",
        "<!---->",
    ),
    *("<!--" + "x" * 100_000 + "-->", "<?a?>" * 20_000, "<!-- -- -->", "<![CDATA[x]]>", "x", "<!ELEMENT a ANY>"),
)


class Made(NamedTuple):
    """A file: how its name ends, and its content."""

    suffix: str
    content: bytes


def made(seed: int) -> Made:
    """The file of a number."""
    return _Grammar(seed).file()


class _Grammar:
    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        # How often a token is hostile: many files have hardly one, so that they come far.
        self.hostile = self.rng.choice((0.0, 0.003, 0.01, 0.03, 0.1, 0.5))
        self.names: list[str] = []

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    def odd(self) -> bool:
        return self.chance(self.hostile)

    def file(self) -> Made:
        kind = self.rng.choices((".urdf", ".xml", ".toml", ".srdf", ".xacro.urdf"), (6, 5, 4, 1, 1))[0]
        make = {
            ".urdf": self.urdf,
            ".xml": self.mjcf,
            ".toml": self.toml,
            ".srdf": self.srdf,
            ".xacro.urdf": self.xacro,
        }
        text = make[kind]()
        if kind != ".toml" and self.chance(0.15):
            text = self.head() + text
        return Made(kind, self.encoded(text))

    def head(self) -> str:
        if self.chance(0.3):
            return f'<?xml version="{self.rng.choice(("1.0", "1.1", "9"))}" encoding="{self.rng.choice(DECLARED)}"?>'
        return self.rng.choice(HEADS)

    def encoded(self, text: str) -> bytes:
        if not self.chance(0.06):
            return text.encode(errors="surrogatepass")
        content = text.encode(self.rng.choice(ENCODINGS), errors="replace")
        if self.chance(0.3):
            content = content[: self.rng.randrange(len(content) + 1)]
        return content

    def figure(self, size: float = 1.0) -> str:
        return self.rng.choice(FIGURES) if self.odd() else repr(round(self.rng.uniform(-size, size), 3))

    def vector(self, count: int = 3, size: float = 1.0) -> str:
        if self.odd():
            count = self.rng.choice((0, 1, 2, 4, 7))
            if self.chance(0.05):
                return "0.1 " * 50_000
        return self.rng.choice((" ", " ", " ", "  ", "\n", "\t")).join(self.figure(size) for _ in range(count))

    def axis(self) -> str:
        return self.rng.choice(AXES) if self.odd() else self.rng.choice(AXES[:3])

    def name(self, usual: str) -> str:
        if self.odd():
            return self.rng.choice((*NAMES, *self.names[-3:]))
        self.names.append(usual)
        return usual

    def tag(self, name: str, inside: str = "", /, **attributes: str) -> str:
        """An element; now and then with an attribute too many, twice the same, a wrong name, or without its end."""
        words = [f"{key.rstrip('_')}={self.quoted(value)}" for key, value in attributes.items()]
        if self.odd():
            words.append(self.rng.choice((*words, 'a="b"', "a=b", "a", 'xmlns:x="y"', 'class="main"', 'name="x"')))
        if words and self.odd():
            words.pop(self.rng.randrange(len(words)))
        if self.odd():
            name = self.rng.choice(
                ("link", "joint", "body", "robot", "default", "include", "x:y", "a" * 1000, "é", "1a")
            )
        end = "" if self.chance(self.hostile / 20) else f"</{name}>"
        return f"<{' '.join([name, *words])}>{inside}{end}"

    def quoted(self, text: str) -> str:
        return f'"{text}"' if self.chance(self.hostile / 10) else quoteattr(text)

    # URDF

    def urdf(self) -> str:
        if self.chance(0.03):
            return self.monster("robot", "link", "joint")
        count = self.rng.choice((0, 1, 3, 7, 7, 7, 7, 8, 9, 14, 60))
        links = [self.name(f"l{k}") for k in range(count + 1)]
        parts = [self.tag("link", self.looks(), name=name) for name in links]
        for k in range(count):
            above = links[k] if not self.odd() else self.rng.choice(links)
            parts.append(self.joint(k, above, links[k + 1]))
        if self.odd():
            self.rng.shuffle(parts)
        return self.tag("robot", "".join(parts), name=self.name("made"))

    def joint(self, k: int, above: str, below: str) -> str:
        kind = self.rng.choice(("revolute", "continuous", "fixed", "prismatic", "floating", "planar", "mimic", ""))
        kind = kind if self.odd() else "revolute"
        height = (0.0, 0.0, 0.3, 0.0, 0.3, 0.0, 0.1)[k % 7]
        xyz = f"0 0 {height}" if not self.odd() else self.vector()
        rpy = "0 0 0" if not self.odd() else self.vector(3, 4.0)
        inside = [
            self.tag("parent", link=above),
            self.tag("child", link=below),
            self.tag("origin", xyz=xyz, rpy=rpy),
            self.tag("axis", xyz=self.axis() if self.odd() else AXES[1 + (k + 1) % 2]),
            self.tag(
                "limit",
                lower="-2" if not self.odd() else self.figure(4),
                upper="2" if not self.odd() else self.figure(4),
                effort="9",
                velocity="2",
            ),
        ]
        if self.odd():
            inside.append(self.tag("mimic", joint=self.name("j1"), multiplier=self.figure()))
        if self.odd():
            inside.append(self.tag("dynamics", damping=self.figure(), friction=self.figure()))
        if self.odd():
            self.rng.shuffle(inside)
        return self.tag("joint", "".join(inside), name=self.name(f"j{k}"), type=kind)

    def looks(self) -> str:
        if self.chance(0.7):
            return ""
        shape = self.rng.choice(
            (
                self.tag("mesh", filename=self.rng.choice(("package://a/b.stl", "/dev/zero", "http://x/y", "../../x"))),
                self.tag("box", size=self.vector()),
                self.tag("sphere", radius=self.figure()),
            )
        )
        inertia = {key: self.figure() for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
        inertial = self.tag("mass", value=self.figure()) + self.tag("inertia", **inertia)
        return self.tag("visual", self.tag("geometry", shape)) + self.tag("inertial", inertial)

    def monster(self, root: str, *tags: str) -> str:
        """Far too much of something."""
        many = self.rng.choice((3_000, 30_000, 300_000))
        tag = self.rng.choice(tags)
        return self.rng.choice(
            (
                lambda: f"<{root}>" + f'<{tag} name="a"/>' * many + f"</{root}>",
                lambda: f"<{root}>" + "".join(f'<{tag} name="n{k}"/>' for k in range(many // 10)) + f"</{root}>",
                lambda: f"<{root}>" + f"<{tag}>" * many + f"</{tag}>" * many + f"</{root}>",
                lambda: f"<{root} " + " ".join(f'a{k}=""' for k in range(many)) + "/>",
                lambda: f'<{root} name="{"x" * 30 * many}"/>',
                lambda: f"<{root}>{'x' * 30 * many}</{root}>",
                lambda: f"<{root}>{'<!-- x -->' * many}</{root}>",
                lambda: f"<{root}><{tag} {' ' * 30 * many}/></{root}>",
                lambda: f"<{'a' * 20 * many}/>",
                lambda: f"<{root}>" + "".join(f"<n{k}/>" for k in range(many)) + f"</{root}>",
                lambda: f"<{root}>" + "&#65;" * many * 4 + f"</{root}>",
                lambda: f'<{root}><{tag} name="{"&#x1F916;" * many}"/></{root}>',
            )
        )()

    # MJCF

    def mjcf(self) -> str:
        if self.chance(0.04):
            return self.monster("mujoco", "worldbody", "default", "body", "include", "compiler", "equality")
        if self.chance(0.02):
            tag = self.rng.choice(("body", "body", "frame"))
            inside = self.rng.choice(("", "<joint/>", "<geom size='1'/>"))
            many = self.rng.choice((100, 300, 600, 990, 5000))
            nested = f"<{tag}>{inside}" * many + f"</{tag}>" * many
            return f"<mujoco><worldbody>{nested}</worldbody></mujoco>"
        sections = [
            self.tag("compiler", **self.some(angle="radian", eulerseq="xyz", autolimits="true", coordinate="local"))
        ]
        sections += [self.default(0) for _ in range(self.rng.choice((0, 0, 1, 2)))]
        sections.append(self.tag("worldbody", self.bodies(self.rng.choice((1, 7, 7, 7, 9)))))
        if self.chance(0.2):
            names = [self.rng.choice([*self.names, "x"]) for _ in range(2)]
            constraint = self.rng.choice(
                (
                    self.tag("joint", joint1=names[0], joint2=names[1]),
                    self.tag("connect", body1=names[0], body2=names[1], anchor=self.vector()),
                    self.tag("weld", site1=names[0], site2=names[1]),
                    self.tag("tendon", tendon1="t"),
                )
            )
            sections.append(self.tag("equality", constraint))
        if self.odd():
            sections.append(
                self.tag(
                    "include",
                    file=self.rng.choice(
                        ("", ".", "/", "made.xml", "/dev/zero", "/dev/stdin", "x\0", "x" * 5000, "/proc/self/mem")
                    ),
                )
            )
        if self.odd():
            self.rng.shuffle(sections)
        return self.tag("mujoco", "".join(sections), model=self.name("made"))

    def some(self, **words: str) -> dict[str, str]:
        wrong = (*NAMES[:8], *FIGURES, "XYZ", "zyx", "auto", "global", "degree")
        return {
            key: self.rng.choice(wrong) if self.odd() else value for key, value in words.items() if self.chance(0.5)
        }

    def default(self, depth: int) -> str:
        inside = [self.tag("joint", **self.some(range="-1 1", limited="true", type="hinge", pos="0 0 0", ref="0"))]
        if depth < 6:
            inside += [self.default(depth + 1) for _ in range(self.rng.choice((0, 0, 1, 2)))]
        return self.tag("default", "".join(inside), **({"class_": self.name(f"c{self.rng.random()}")} if depth else {}))

    def bodies(self, count: int) -> str:
        text = ""
        for k in range(count):
            inner = self.tag(
                "joint",
                name=self.name(f"j{k}"),
                axis=AXES[1 + (k + 1) % 2],
                range="-2 2",
                **self.some(pos="0 0 0", type="hinge", ref="0", limited="true"),
            )
            inner += self.tag(
                "geom",
                size="0.1",
                **self.some(type="sphere", mass="1", density="5", group="1", mesh="m", fromto="0 0 0 0 0 1"),
            )
            if self.odd():
                inner += self.rng.choice(
                    (
                        self.tag("freejoint"),
                        self.tag("inertial", pos=self.vector(), mass=self.figure(), diaginertia=self.vector()),
                        self.tag("frame", self.tag("body"), pos=self.vector(), euler=self.vector()),
                        self.tag("replicate", self.tag("geom"), count="1000000000"),
                        self.tag("attach", model="m", prefix=""),
                        self.tag("site", fromto=self.vector(6)),
                        self.tag("composite", type="grid", count="1000 1000 1000"),
                        self.tag("plugin", plugin="a.b"),
                    )
                )
            turned = {
                self.rng.choice(("quat", "euler", "zaxis", "xyaxes", "axisangle")): self.vector(
                    self.rng.choice((3, 4, 6))
                )
            }
            height = (0.0, 0.0, 0.3, 0.0, 0.3, 0.0, 0.1)[k % 7]
            pos = f"0 0 {height}" if not self.odd() else self.vector()
            text += self.tag(
                "body", inner, name=self.name(f"b{k}"), pos=pos, **(turned if self.odd() else {})
            ).removesuffix("</body>")
        return text + "</body>" * count

    # Adapters, SRDF, xacro

    def toml(self) -> str:
        if self.chance(0.05):
            return self.rng.choice(
                (
                    lambda: "a." * 40_000 + "a = 1",
                    lambda: "name = " + "[" * 30_000,
                    lambda: "name = " + "{a = " * 10_000,
                    lambda: "year = 0x" + "F" * 60_000,
                    lambda: "\n".join(f"[a.b.c.d.e.f.g{k}]" for k in range(3_000)),
                    lambda: 'name = "' + '\\"' * 30_000,
                    lambda: '"a"."b".' * 8_000 + "a = 1",
                    lambda: "\n".join("[[a.b]]" for _ in range(8_000)),
                    lambda: "a" * 60_000,
                    lambda: "name = '" + "x" * 60_000 + "'",
                    lambda: "[limits]\n" + "\n".join(f"j{k} = {{ lower = 1 }}" for k in range(2_500)),
                )
            )()
        lines = [
            f"name = {self.value(chr(34) + 'made' + chr(34))}",
            f"urdf = {self.value(chr(34) + 'ADAPTED' + chr(34))}",
        ]
        if self.chance(0.5):
            lines.append(f"side = {self.value(chr(34) + 'left' + chr(34))}")
        lines += [
            "[frames]",
            f"base = {self.value(chr(34) + 'l0' + chr(34))}",
            f"tip = {self.value(chr(34) + 'l7' + chr(34))}",
        ]
        tables = {
            "arm_angle": {"reference": "[1.0, 0.0, 0.0]"},
            "hand": {"grasp": "[0.0, 0.0, 1.0]", "pronosupination": "[1.0, 0.0, 0.0]"},
            "tool": {"xyz": "[0.0, 0.0, 0.1]", "rpy": "[0.0, 0.5, 0.0]", "name": '"tool"'},
            "mount": {"xyz": "[0.0, 0.0, 0.1]", "name": '"room"', "gravity": "[0.0, 0.0, -9.81]"},
            "limits": {"j1": "{ lower = -1.0, upper = 1.0 }", "j2": "{ velocity = inf }"},
            "xacro": {"a": '"b"'},
            "sources.a": {"figures": '"f"', "title": '"t"', "year": "2020"},
        }
        for table, content in tables.items():
            if self.chance(0.4):
                lines.append(f"[{table}]" if not self.odd() else f"[[{table}]]")
                lines += [f"{key} = {self.value(value)}" for key, value in content.items()]
        if self.odd():
            self.rng.shuffle(lines)
        return "\n".join(lines)

    def value(self, usual: str) -> str:
        if not self.odd():
            return usual
        return self.rng.choice(
            (
                *FIGURES[:30],
                *(
                    "1979-05-27",
                    "[]",
                    "{}",
                    "[[[[1]]]]",
                    "true",
                    '""',
                    "1" + "0" * 400,
                    "[1, 2]",
                    "[nan, 0, 1]",
                    "[1e308, 1e308, 1e308]",
                ),
                *(
                    "'''\n'''",
                    '"\\uD800"',
                    '"\\U0010FFFF"',
                    "[" + "1, " * 1000 + "]",
                    "0b" + "1" * 2000,
                    "9" * 4301,
                    '"a.xacro"',
                ),
                *('"package://a/b"', '"robot_descriptions://x"', '"https://x"', '"/dev/zero"', '"."', '"\\u0000"'),
            )
        )

    def srdf(self) -> str:
        groups = [
            self.tag(
                "group", self.tag("chain", base_link=self.name("l0"), tip_link=self.name("l7")), name=self.name(f"g{k}")
            )
            for k in range(self.rng.choice((0, 1, 1, 2, 500)))
        ]
        return self.tag("robot", "".join(groups), name="made")

    def xacro(self) -> str:
        """A program that nobody has asked to run."""
        inside = self.rng.choice(
            (
                "<xacro:include filename='/etc/passwd'/>",
                "<xacro:property name='a' value='${open(\"/tmp/srs_ik_xacro_ran\", \"w\")}'/>",
                "<link name='a'/><xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/>",
                "<link name='a'><xacro:if value='${True}'/></link>",
            )
        )
        return f"<robot name='made' xmlns:xacro='http://www.ros.org/wiki/xacro'>{inside}</robot>"
