"""Robots as other people write them: cylinder wheels, default contacts, names of their own."""

from __future__ import annotations

from pathlib import Path

RADIUS, HALF_TRACK, MASS = 0.05, 0.12, 4.3

FREE_CASTER = (
    '<geom name="ball" type="sphere" size="0.02" pos="-0.15 0 -0.03" mass="0.1" condim="1" priority="1"/>'
)
BRAKING_CASTER = (
    '<geom name="ball" type="sphere" size="0.02" pos="-0.15 0 -0.03" mass="0.1" condim="1" friction="0"/>'
)
SWIVEL_CASTER = """
<body name="fork" pos="-0.15 0 0"><joint name="swivel" axis="0 0 1"/>
  <geom type="box" size="0.005 0.01 0.005" mass="0.05" contype="0" conaffinity="0"/>
  <body name="caster_wheel" pos="-0.02 0 -0.03"><joint name="roll" axis="0 1 0"/>
    <geom name="ball" type="sphere" size="0.02" mass="0.05"/></body></body>"""
ACTUATORS = '<velocity name="go_left" joint="wheel_left" kv="1"/><motor name="go_right" joint="wheel_right"/>'


def wheel(name: str, y: float, x: float = 0.0, axis: str = "0 0 1") -> str:
    """A cylinder whose frame lies on its side, so that its axle is its z."""
    return (
        f'<body name="{name}_link" pos="{x} {y} 0" euler="-90 0 0"><joint name="{name}" axis="{axis}"/>'
        f'<geom name="{name}_geom" type="cylinder" size="{RADIUS} 0.015" mass="0.1"/></body>'
    )


def mjcf(
    *,
    wheels: str | None = None,
    caster: str = FREE_CASTER,
    free: str = "<freejoint/>",
    actuators: str = ACTUATORS,
    world: str = '<geom name="ground" type="plane" size="5 5 0.1"/>',
    extra: str = "",
    option: str = "",
    turned: float = 0.0,
) -> str:
    """A robot of 4.3 kg whose base stands 0.05 m over its floor, away from the origin and turned [deg]."""
    wheels = wheel("wheel_left", HALF_TRACK) + wheel("wheel_right", -HALF_TRACK) if wheels is None else wheels
    return f"""
<mujoco model="somebody's"><compiler angle="degree"/><option timestep="0.004" {option}/>
<worldbody>{world}
  <body name="chassis" pos="1 2 {RADIUS}" euler="0 0 {turned}">{free}
    <geom name="hull" type="box" size="0.12 0.08 0.03" pos="-0.03 0 0.03" mass="4"/>
    {caster}{wheels}
  </body>
</worldbody>
<actuator>{actuators}</actuator>{extra}
</mujoco>"""


def urdf(joint: str = "continuous", extra: str = "") -> str:
    """The same robot as a URDF, which MuJoCo welds to the world."""

    def link(name: str, mass: float, shape: str) -> str:
        inertia = " ".join(f'{axis}="{0.002 * mass}"' for axis in ("ixx", "iyy", "izz"))
        centre = "-0.03 0 0.02" if mass > 1 else "0 0 0"
        return f"""
  <link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>
    <inertia {inertia} ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>"""

    tyre = f'<cylinder radius="{RADIUS}" length="0.03"/>'
    rim = f"<collision><geometry>{tyre}</geometry></collision>"
    under = '<origin xyz="-0.15 0 -0.03"/>'
    ball = f'<collision>{under}<geometry><sphere radius="0.02"/></geometry></collision>'
    joints = "".join(
        f"""
  <joint name="{side}_wheel_joint" type="{joint}"><parent link="base_link"/><child link="{side}_wheel"/>
    <origin xyz="0 {y} 0" rpy="-1.5707963 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="2" velocity="9"/></joint>"""
        for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK))
    )
    links = link("base_link", 4.1, ball) + link("left_wheel", 0.1, rim) + link("right_wheel", 0.1, rim)
    return f'<robot name="somebody">{links}{joints}{extra}</robot>'


def written(folder: Path, text: str, name: str = "robot.xml") -> Path:
    """Write a model file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
