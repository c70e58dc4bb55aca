//! Columns of tables written before void ratios counted the lost mass unless their name says otherwise: `porosity`, `void_ratio` and
//! `porosity_star` stood for what is left in grains then, and `_restored` after the name for all dry mass.

/// What a table of means has after the name of a column, and a history has not.
const SUFFIXES: [&str; 5] = ["", "_mean", "_sd", "_low", "_high"];

/// Gives the columns of an old table the names that they have now; a table that has no `_restored` column is left as it is.
pub fn renew(headers: &mut [String]) {
    for base in ["porosity", "void_ratio", "porosity_star"] {
        for suffix in SUFFIXES {
            let [old, plain, grains] = ["_restored", "", "_grains"].map(|part| format!("{base}{part}{suffix}"));
            if !headers.contains(&old) {
                continue;
            }
            for header in headers.iter_mut() {
                if *header == plain {
                    header.clone_from(&grains);
                } else if *header == old {
                    header.clone_from(&plain);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn renewed(headers: &[&str]) -> Vec<String> {
        let mut headers: Vec<String> = headers.iter().map(|h| (*h).to_string()).collect();
        renew(&mut headers);
        headers
    }

    #[test]
    fn old_columns_get_todays_names_and_others_keep_theirs() {
        assert_eq!(renewed(&["porosity", "k0", "porosity_restored"]), ["porosity_grains", "k0", "porosity"]);
        assert_eq!(renewed(&["porosity_star", "porosity_star_restored"]), ["porosity_star_grains", "porosity_star"]);
        assert_eq!(renewed(&["void_ratio_mean", "void_ratio_restored_mean"]), ["void_ratio_grains_mean", "void_ratio_mean"]);
        assert_eq!(renewed(&["sigma_v_kPa", "void_ratio_restored"]), ["sigma_v_kPa", "void_ratio"], "a measured curve");
        assert_eq!(renewed(&["porosity", "porosity_grains"]), ["porosity", "porosity_grains"]);
    }
}
