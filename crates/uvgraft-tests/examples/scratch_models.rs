#![allow(missing_docs)]
use uvgraft_io::arrays::NumericArray;
use uvgraft_tests::made_up::{self, Entanglement};
fn main() {
    let out = std::path::PathBuf::from(std::env::args().nth(1).unwrap());
    let few = Entanglement { components: 20, ..Entanglement::default() };
    for (n, m) in [("smplx", made_up::smplx(&few)), ("flame", made_up::flame(&few))] {
        let mut m = m.unwrap();
        m.truths.rotate_left(4);
        let n_v = m.mesh.positions().len();
        let k = m.truths.len();
        let mut v = Vec::new();
        for i in 0..n_v {
            for a in 0..3 {
                for t in &m.truths {
                    v.push(t.offsets[i][a]);
                }
            }
        }
        m.arrays.insert("exprdirs", NumericArray::new_f32(vec![n_v, 3, k], v).unwrap());
        uvgraft_io::arrays::save_npz(&m.arrays, &out.join(format!("{n}.npz"))).unwrap();
        println!("{n} {:?}", m.truths.iter().map(|t| t.name).collect::<Vec<_>>());
    }
}
