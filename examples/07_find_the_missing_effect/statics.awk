# What the channels of a row say together, whatever the soil model is. Columns by name; r [m] and tan_phi by -v.
# N, S: normal and tangential resultant of the contact; theta: where on the rim they act; theta_f: where the rim enters the soil.
#   S = T/r,  theta = asin(S/hypot(W, F)) - atan2(F, W),  N = W cos theta - F sin theta,  theta_f = acos(1 - z/r)
function asin(x) { return atan2(x, sqrt(1 - x * x)) }
function acos(x) { return atan2(sqrt(1 - x * x), x) }
NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i
          print "slip,load_N,theta_deg,theta_f_deg,theta_over_theta_f,S_over_N,tan_phi,says" }
NR > 1 && $at["torque_Nm"] != "" {
  z = at["sinkage_m"] ? $at["sinkage_m"] : $at["sinkage_mm"] / 1000
  W = $at["load_N"]; F = $at["drawbar_N"]; S = $at["torque_Nm"] / r
  theta = asin(S / sqrt(W * W + F * F)) - atan2(F, W)
  theta_f = acos(1 - z / r)
  N = W * cos(theta) - F * sin(theta)
  says = theta > theta_f ? "pushed from outside the contact" : theta > 0.75 * theta_f ? "pushed at the very front" : ""
  printf "%s,%s,%.1f,%.1f,%.2f,%.2f,%.2f,%s\n", $at["slip"], W, 57.29578 * theta, 57.29578 * theta_f, theta / theta_f, S / N, tan_phi, says
}
